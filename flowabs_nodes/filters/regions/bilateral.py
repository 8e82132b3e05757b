"""The bilateral filter, full and x-y separable: what the paper compares the flow-based one with (Figs. 16-21)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.choices import BILATERAL_KERNELS
from flowabs_nodes.filters import gaussian, validate
from flowabs_nodes.filters.regions.range_weights import range_exponent, spatial_exponents
from flowabs_nodes.sampling.samples import TINY
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.border import repeat_left, repeat_right
from flowabs_nodes.simd.elementary import exp2_weight
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, select, splat_floats
from flowabs_nodes.simd.memory import load, load_triples, store, store_triples


def bilateral(
    codes: npt.ArrayLike,
    sigma_d: float = 2.0,
    sigma_r: float = 10.0,
    iterations: int = 3,
    kernel: str = "full",
    alpha: npt.ArrayLike | None = None,
) -> Array:
    """The bilateral filter of Tomasi and Manduchi [33], ``iterations`` times.

    Each pixel becomes the mean of its neighbours, weighted by exp(-d^2 / 2 sigma_d^2) exp(-r^2 / 2 sigma_r^2), with d
    the distance in pixels and r the Euclidean distance of code values, both to the pixel itself.

    Parameters
    ----------
    codes
        Code values, (H, W, 3), not multiplied by alpha.
    sigma_d
        Sigma of the distance in pixels, 0 to 1,000; 0 gives a copy. Neighbours beyond the border repeat it.
    sigma_r
        Sigma of the difference of colour in code values, above 0.
    iterations
        At least 0; 0 gives a copy.
    kernel
        "full": all neighbours in the square of +-ceil(3 sigma_d). "xy": those in the same row, then, of what that
        gave, those in the same column, in each iteration (Pham and van Vliet [50]).
    alpha
        (H, W), coverage: every neighbour's weight is multiplied by its alpha, so that the colour of what is not there
        never shows. Pixels with alpha 0 or less keep their value. None is 1 everywhere.

    Returns
    -------
    The smoothed code values, (H, W, 3) float32.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    codes = validate.planes("codes", codes)
    sigma_d = validate.number("sigma_d", sigma_d, min=0, max=1000)
    sigma_r = validate.number("sigma_r", sigma_r, above=0)
    iterations = validate.whole("iterations", iterations, min=0)
    radius = gaussian.radius(sigma_d)
    windows = (
        [(radius, radius)]
        if validate.choice("kernel", kernel, BILATERAL_KERNELS) == "full"
        else [(radius, 0), (0, radius)]
    )
    there = np.ones(codes.shape[:2], np.float32) if alpha is None else validate.plane("alpha", alpha, codes.shape)

    height, width, _ = codes.shape
    if width < LANES:  # what is beyond the width is cut off again
        beyond = ((0, 0), (0, LANES - width))
        codes, there = np.pad(codes, (*beyond, (0, 0)), "edge"), np.pad(there, beyond, "edge")
    # Each row as four planes, L, a, b and alpha, the border repeated on both sides as far as a neighbour may lie.
    size = Size(height, width, codes.shape[1], radius)
    picture, smoothed = np.empty((2, height * 4 * (size.stride + 2 * radius)), np.float32)
    over_rows(_lay_out, height, codes.reshape(-1), there.reshape(-1), size, picture)
    for _ in range(iterations):
        for across, down in windows:
            over_rows(
                _smooth,
                height,
                picture,
                spatial_exponents(sigma_d),
                range_exponent(sigma_r),
                across,
                down,
                size,
                smoothed,
            )
            picture, smoothed = smoothed, picture
    result = np.empty_like(codes)
    over_rows(_take_out, height, picture, codes.reshape(-1), size, result.reshape(-1))
    return np.ascontiguousarray(result[:, :width])


class Size(NamedTuple):
    """Of a picture: rows of ``stride`` pixels, the first ``width`` of which count, and ``margin`` more on each side."""

    height: int
    width: int
    stride: int
    margin: int


@inlined
def _row(y: int, size: Size) -> tuple[int, int]:
    """Where the first pixel of row y is, and how far its planes are apart."""
    plane = size.stride + 2 * size.margin
    return 4 * y * plane + size.margin, plane


@kernel
def _lay_out(first: int, last: int, codes: Any, alpha: Any, size: Size, picture: Any) -> None:
    nothing = splat_floats(0.0)
    for y in range(first, last):
        row, plane = _row(y, size)
        for x0 in range(0, size.stride, LANES):
            x = min(x0, size.stride - LANES)
            i = y * size.stride + x
            l0, a0, b0 = load_triples(codes, 3 * i)
            k = load(alpha, i)
            there = k > TINY
            store(picture, row + x, select(there, l0, nothing))
            store(picture, row + plane + x, select(there, a0, nothing))
            store(picture, row + 2 * plane + x, select(there, b0, nothing))
            store(picture, row + 3 * plane + x, select(there, k, nothing))
        _repeat_borders(picture, y, size)


@inlined
def _repeat_borders(picture: Any, y: int, size: Size) -> None:
    row, plane = _row(y, size)
    for c in range(4):
        repeat_left(picture, row + c * plane, size.margin, 1)
        repeat_right(picture, row + c * plane + size.width, size.margin, 1)


@kernel
def _take_out(first: int, last: int, picture: Any, codes: Any, size: Size, result: Any) -> None:
    for y in range(first, last):
        row, plane = _row(y, size)
        for x0 in range(0, size.stride, LANES):
            x = min(x0, size.stride - LANES)
            i = 3 * (y * size.stride + x)
            there = load(picture, row + 3 * plane + x) > 0.0
            l0, a0, b0 = load_triples(codes, i)
            l0 = select(there, load(picture, row + x), l0)
            a0 = select(there, load(picture, row + plane + x), a0)
            b0 = select(there, load(picture, row + 2 * plane + x), b0)
            store_triples(result, i, (l0, a0, b0))


@kernel
def _smooth(
    first: int,
    last: int,
    picture: Any,
    spatial_exponents: Any,
    range_exponent: Any,
    across: int,
    down: int,
    size: Size,
    smoothed: Any,
) -> None:
    """One pass over a window of +-``across`` columns and +-``down`` rows."""
    for y in range(first, last):
        row, plane = _row(y, size)
        for x0 in range(0, size.stride, LANES):
            x = min(x0, size.stride - LANES)
            l0, a0, b0 = load(picture, row + x), load(picture, row + plane + x), load(picture, row + 2 * plane + x)
            alpha = load(picture, row + 3 * plane + x)
            sums = (
                splat_floats(0.0),
                splat_floats(0.0),
                splat_floats(0.0),
                alpha,
            )  # the pixel itself: its difference is 0
            # The weight of a distance is that of the opposite one, so neighbours are taken in pairs.
            for dy in range(down + 1):
                above, _ = _row(max(y - dy, 0), size)
                below, _ = _row(min(y + dy, size.height - 1), size)
                for dx in range(-across if dy > 0 else 1, across + 1):
                    near = spatial_exponents[abs(dx)] + spatial_exponents[dy]
                    sums = _weigh(sums, picture, above + x - dx, plane, l0, a0, b0, near, range_exponent)
                    sums = _weigh(sums, picture, below + x + dx, plane, l0, a0, b0, near, range_exponent)
            dl, da, db, weight = sums
            over = select(alpha > 0.0, 1.0 / weight, 0.0)
            store(smoothed, row + x, l0 + over * dl)
            store(smoothed, row + plane + x, a0 + over * da)
            store(smoothed, row + 2 * plane + x, b0 + over * db)
            store(smoothed, row + 3 * plane + x, alpha)
        _repeat_borders(smoothed, y, size)


@inlined
def _weigh(
    sums: Any, picture: Any, i: int, plane: int, l0: Any, a0: Any, b0: Any, near: Any, range_exponent: Any
) -> Any:
    """Add a neighbour of each pixel, weighted by alpha, distance and colour; sums of differences round the least."""
    dl, da, db, weight = sums
    el, ea, eb = load(picture, i) - l0, load(picture, i + plane) - a0, load(picture, i + 2 * plane) - b0
    w = load(picture, i + 3 * plane) * exp2_weight(near + range_exponent * (el * el + ea * ea + eb * eb))
    return dl + w * el, da + w * ea, db + w * eb, weight + w
