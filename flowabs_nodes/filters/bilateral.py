"""The bilateral filter, full and x-y separable: what the paper compares the flow-based one with (Figs. 16-21)."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from numba import prange

from flowabs_nodes.filters import arguments, gaussian
from flowabs_nodes.filters.arguments import Array
from flowabs_nodes.filters.blocks import COLUMNS, Block, inline, u
from flowabs_nodes.filters.exponential import exp2
from flowabs_nodes.filters.kernels import kernel, parallel_kernel
from flowabs_nodes.filters.similarity import TINY, Sums, closeness, coverage, falloff, new_sums

KERNELS = ("full", "xy")


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
    codes = arguments.planes("codes", codes)
    sigma_d = arguments.number("sigma_d", sigma_d, min=0, max=1000)
    sigma_r = arguments.number("sigma_r", sigma_r, above=0)
    iterations = arguments.whole("iterations", iterations, min=0)
    radius = gaussian.radius(sigma_d)
    windows = (
        [(radius, radius)] if arguments.choice("kernel", kernel, KERNELS) == "full" else [(radius, 0), (0, radius)]
    )
    there = coverage(alpha, codes)

    # Each row as four planes, L, a, b and alpha, each repeated on both sides as far as a neighbour may lie.
    height, width, _ = codes.shape
    picture, smoothed = np.empty((2, height, 4, width + 2 * radius), np.float32)
    _lay_out(codes, there, radius, picture)
    smoothed[:, 3] = picture[:, 3]
    for _ in range(iterations):
        for across, down in windows:
            _smooth(picture, closeness(sigma_d), falloff(sigma_r), across, down, radius, smoothed)
            picture, smoothed = smoothed, picture
    result = np.empty_like(codes)
    _take_out(picture, codes, radius, result)
    return result


@parallel_kernel
def _lay_out(codes: Any, alpha: Any, margin: int, picture: Any) -> None:
    height, width, _ = codes.shape
    for y in prange(height):
        for x in range(width):
            a = alpha[y, x] if alpha[y, x] > TINY else np.float32(0.0)
            picture[y, 3, margin + x] = a
            for c in range(3):
                picture[y, c, margin + x] = codes[y, x, c] if a > 0 else np.float32(0.0)
        for c in range(4):
            for x in range(margin):
                picture[y, c, x] = picture[y, c, margin]
                picture[y, c, margin + width + x] = picture[y, c, margin + width - 1]


@parallel_kernel
def _take_out(picture: Any, codes: Any, margin: int, result: Any) -> None:
    height, width, _ = codes.shape
    for y in prange(height):
        for x in range(width):
            for c in range(3):
                result[y, x, c] = picture[y, c, margin + x] if picture[y, 3, margin + x] > 0 else codes[y, x, c]


@parallel_kernel
def _smooth(picture: Any, closeness: Any, falloff: Any, across: int, down: int, margin: int, smoothed: Any) -> None:
    """One pass over a window of +-``across`` columns and +-``down`` rows."""
    height, _, stride = picture.shape
    source, target = picture.reshape(-1), smoothed.reshape(-1)
    for y in prange(height):
        _smooth_row(
            source, closeness, falloff, across, down, margin, np.int64(y), stride - 2 * margin, height, stride, target
        )


@kernel
def _smooth_row(
    picture: Any,
    closeness: Any,
    falloff: Any,
    across: int,
    down: int,
    margin: int,
    y: int,
    width: int,
    height: int,
    stride: int,
    smoothed: Any,
) -> None:
    sums = new_sums()
    row = 4 * stride
    for x in range(0, width, COLUMNS):
        block = Block(x, y, u(min(COLUMNS, width - x)), width, height)
        here = y * row + margin + x
        _begin(sums, picture, u(here), u(stride), block)
        # The weight of a distance is that of the opposite one, so neighbours are taken in pairs.
        for dy in range(down + 1):
            above, below = here + (max(y - dy, 0) - y) * row, here + (min(y + dy, height - 1) - y) * row
            for dx in range(-across if dy > 0 else 1, across + 1):
                near = closeness[u(abs(dx))] + closeness[u(dy)]
                _weigh_pair(sums, picture, u(above - dx), u(below + dx), u(stride), near, falloff, block)
        _finish(sums, picture, smoothed, u(here), u(stride), block)
    for c in range(3):
        first = u(y * row + c * stride)
        for x in range(u(margin)):
            smoothed[first + x] = smoothed[first + u(margin)]
            smoothed[first + u(margin + width) + x] = smoothed[first + u(margin + width - 1)]


@inline
def _begin(sums: Sums, picture: Any, here: Any, stride: Any, block: Block) -> None:
    """The pixel itself counts with its own alpha; its difference is 0."""
    for i in range(block.size):
        sums.l[i] = picture[here + i]
        sums.a[i] = picture[here + stride + i]
        sums.b[i] = picture[here + u(2) * stride + i]
        sums.dl[i] = np.float32(0.0)
        sums.da[i] = np.float32(0.0)
        sums.db[i] = np.float32(0.0)
        sums.weight[i] = picture[here + u(3) * stride + i]


@inline
def _weigh_pair(
    sums: Sums, picture: Any, one: Any, other: Any, stride: Any, near: Any, falloff: Any, block: Block
) -> None:
    """Add two neighbours of each pixel, weighted by alpha, distance and colour."""
    for i in range(block.size):
        l, a, b = sums.l[i], sums.a[i], sums.b[i]  # noqa: E741
        dl = picture[one + i] - l
        da = picture[one + stride + i] - a
        db = picture[one + u(2) * stride + i] - b
        weight = picture[one + u(3) * stride + i] * exp2(near + falloff * (dl * dl + da * da + db * db))
        el = picture[other + i] - l
        ea = picture[other + stride + i] - a
        eb = picture[other + u(2) * stride + i] - b
        weight_2 = picture[other + u(3) * stride + i] * exp2(near + falloff * (el * el + ea * ea + eb * eb))
        sums.dl[i] += weight * dl + weight_2 * el
        sums.da[i] += weight * da + weight_2 * ea
        sums.db[i] += weight * db + weight_2 * eb
        sums.weight[i] += weight + weight_2


@inline
def _finish(sums: Sums, picture: Any, smoothed: Any, here: Any, stride: Any, block: Block) -> None:
    for i in range(block.size):
        over = np.float32(1.0) / sums.weight[i] if picture[here + u(3) * stride + i] > 0 else np.float32(0.0)
        smoothed[here + i] = sums.l[i] + over * sums.dl[i]
        smoothed[here + stride + i] = sums.a[i] + over * sums.da[i]
        smoothed[here + u(2) * stride + i] = sums.b[i] + over * sums.db[i]
