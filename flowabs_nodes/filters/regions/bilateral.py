"""The bilateral filter, full and x-y separable, with which the paper compares the flow-based one (Figs. 16-21).

The kernels work on rows of four planes: L, a, b and alpha of a row of pixels, each with a margin on both sides that
repeats the border, one after the other. All rows together are one 1-D array (:class:`Planes`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.choices import BILATERAL_KERNELS
from flowabs_nodes.filters import gaussian, validate
from flowabs_nodes.filters.regions.range_weights import (
    Sums,
    WeightExponents,
    add_sample,
    start_sums,
    weight_exponents,
)
from flowabs_nodes.sampling.samples import Color
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.border import repeat_left, repeat_right
from flowabs_nodes.simd.finite import is_finite, refuse_overflow
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, select, splat_floats
from flowabs_nodes.simd.memory import load, load_triples, store, store_triples
from flowabs_nodes.simd.premultiplied import TINY


def bilateral(
    codes: npt.ArrayLike,
    sigma_d: float = 2.0,
    sigma_r: float = 10.0,
    iterations: int = 3,
    kernel: str = "full",
    alpha: npt.ArrayLike | None = None,
) -> Array:
    """Smooth a picture by the bilateral filter of Tomasi and Manduchi [33], ``iterations`` times.

    Each pixel becomes the mean of its neighbours and itself with weights exp(-d^2 / 2 sigma_d^2) times
    exp(-r^2 / 2 sigma_r^2), where d is the distance in pixels and r the Euclidean distance of code values, both to the
    pixel itself.

    Parameters
    ----------
    codes
        Code values, (H, W, 3), not multiplied by alpha.
    sigma_d
        Sigma of the spatial kernel in pixels, 0 to 1,000; 0 gives a copy. The border is repeated.
    sigma_r
        Sigma of the range kernel in code values, above 0.
    iterations
        At least 0; 0 gives a copy.
    kernel
        "full": all neighbours in the square of +-ceil(3 sigma_d). "xy": in each iteration the neighbours in the same
        row, then, in the picture that this gives, the neighbours in the same column (Pham and van Vliet [50]).
    alpha
        Coverage, (H, W). The weight of every neighbour is multiplied by its alpha, so that the colour of an uncovered
        pixel never shows. Pixels with alpha 0 or less keep their value. None is 1 everywhere.

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
    is_full = validate.choice("kernel", kernel, BILATERAL_KERNELS) == "full"
    windows = [(radius, radius)] if is_full else [(radius, 0), (0, radius)]
    covered = np.ones(codes.shape[:2], np.float32) if alpha is None else validate.plane("alpha", alpha, codes.shape)

    height, width, _ = codes.shape
    if width < LANES:  # rows of fewer than sixteen pixels are widened for the kernels, and narrowed at the end
        beyond = ((0, 0), (0, LANES - width))
        codes, covered = np.pad(codes, (*beyond, (0, 0)), "edge"), np.pad(covered, beyond, "edge")
    planes = Planes(height, width, codes.shape[1], radius)
    picture, smoothed = np.empty((2, height * 4 * (planes.stride + 2 * radius)), np.float32)
    over_rows(_to_planes, height, codes.reshape(-1), covered.reshape(-1), planes, picture)
    weights = weight_exponents(sigma_d, sigma_r)
    for _ in range(iterations):
        for across, down in windows:
            over_rows(_smooth, height, picture, weights, across, down, planes, smoothed)
            picture, smoothed = smoothed, picture
    result = np.empty_like(codes)
    over_rows(_from_planes, height, picture, codes.reshape(-1), planes, result.reshape(-1))
    result = np.ascontiguousarray(result[:, :width])
    if not is_finite(result):
        refuse_overflow("codes", codes[:, :width], result)
    return result


class Planes(NamedTuple):
    """The layout of a picture as rows of four planes: of ``stride`` pixels per row, the first ``width`` are its own."""

    height: int
    width: int
    stride: int
    margin: int  # pixels to each side of a plane


@inlined
def _row(y: int, planes: Planes) -> tuple[int, int]:
    """Return the index of the first pixel of row y in its first plane, and the distance from plane to plane."""
    plane = planes.stride + 2 * planes.margin
    return 4 * y * plane + planes.margin, plane


@kernel
def _to_planes(first: int, last: int, codes: Array, alpha: Array, planes: Planes, picture: Array) -> None:
    """Write rows ``first`` .. ``last`` - 1 as planes; pixels whose alpha is 0 or too small to divide by become 0.

    ``codes`` is (H, stride, 3) and ``alpha`` (H, stride), both flattened.
    """
    nothing = splat_floats(0.0)
    for y in range(first, last):
        row, plane = _row(y, planes)
        for x0 in range(0, planes.stride, LANES):
            x = min(x0, planes.stride - LANES)
            i = y * planes.stride + x
            l0, a0, b0 = load_triples(codes, 3 * i)
            k = load(alpha, i)
            there = k > TINY
            store(picture, row + x, select(there, l0, nothing))
            store(picture, row + plane + x, select(there, a0, nothing))
            store(picture, row + 2 * plane + x, select(there, b0, nothing))
            store(picture, row + 3 * plane + x, select(there, k, nothing))
        _repeat_borders(picture, y, planes)


@inlined
def _repeat_borders(picture: Array, y: int, planes: Planes) -> None:
    """Fill the margins of the four planes of row y with the pixels at the border."""
    row, plane = _row(y, planes)
    for c in range(4):
        repeat_left(picture, row + c * plane, planes.margin, 1)
        repeat_right(picture, row + c * plane + planes.width, planes.margin, 1)


@kernel
def _from_planes(first: int, last: int, picture: Array, codes: Array, planes: Planes, result: Array) -> None:
    """Write the colours of rows ``first`` .. ``last`` - 1 to ``result``; where alpha is 0, those of ``codes``.

    ``codes`` and ``result`` are (H, stride, 3), flattened.
    """
    for y in range(first, last):
        row, plane = _row(y, planes)
        for x0 in range(0, planes.stride, LANES):
            x = min(x0, planes.stride - LANES)
            i = 3 * (y * planes.stride + x)
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
    picture: Array,
    weights: WeightExponents,
    across: int,
    down: int,
    planes: Planes,
    smoothed: Array,
) -> None:
    """Smooth rows ``first`` .. ``last`` - 1 once, over a window of +-``across`` columns and +-``down`` rows."""
    spatial, range_exponent = weights
    for y in range(first, last):
        row, plane = _row(y, planes)
        for x0 in range(0, planes.stride, LANES):
            x = min(x0, planes.stride - LANES)
            centre = _load_color(picture, row + x, plane)
            sums = start_sums(centre)
            # Opposite neighbours have the same spatial weight, so they are added in pairs.
            for dy in range(down + 1):
                above, _ = _row(max(y - dy, 0), planes)
                below, _ = _row(min(y + dy, planes.height - 1), planes)
                for dx in range(-across if dy > 0 else 1, across + 1):
                    near = spatial[abs(dx)] + spatial[dy]
                    sums = _add_neighbour(sums, centre, picture, above + x - dx, plane, near, range_exponent)
                    sums = _add_neighbour(sums, centre, picture, below + x + dx, plane, near, range_exponent)
            over = select(centre.alpha > 0.0, 1.0 / sums.weight, 0.0)
            store(smoothed, row + x, centre.l + over * sums.l)
            store(smoothed, row + plane + x, centre.a + over * sums.a)
            store(smoothed, row + 2 * plane + x, centre.b + over * sums.b)
            store(smoothed, row + 3 * plane + x, centre.alpha)
        _repeat_borders(smoothed, y, planes)


@inlined
def _load_color(picture: Array, i: int, plane: int) -> Color:
    """Return sixteen pixels, of which the first is at ``i`` in its first plane."""
    return Color(load(picture, i), load(picture, i + plane), load(picture, i + 2 * plane), load(picture, i + 3 * plane))


@inlined
def _add_neighbour(
    sums: Sums, centre: Color, picture: Array, i: int, plane: int, near: float, range_exponent: float
) -> Sums:
    """Return the sums with one more neighbour of each centre; ``near`` is log2 of its spatial weight."""
    added: Sums = add_sample(sums, centre, _load_color(picture, i, plane), near, range_exponent, True)
    return added
