"""The plain Gaussian blur, separable, border repeated."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters import gaussian, validate
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.border import repeat_left, repeat_right
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.lanes import LANES, from_doubles, to_doubles
from flowabs_nodes.simd.memory import load, store


def blur(image: npt.ArrayLike, sigma: float = 1.0) -> Array:
    """Gaussian blur of each channel, the border repeated.

    Parameters
    ----------
    image
        (H, W) or (H, W, C), any scale; RGBA premultiplied.
    sigma
        Standard deviation in pixels, 0 to 10,000; 0 gives a copy. Cut at ceil(3 sigma).

    Returns
    -------
    The blurred image, float32, of the same shape.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a sigma out of range.
    """
    image = validate.any_channels("image", image)
    sigma = validate.number("sigma", sigma, min=0, max=10_000)
    if sigma == 0:
        return image.copy()
    return separable(image, gaussian.half(sigma))


def separable(image: Array, weights: npt.NDArray[np.float64]) -> Array:
    """The weighted sum over rows, then columns, in float64; ``weights``: of the offsets 0, 1 .. to either side."""
    height, width = image.shape[:2]
    rows = image.reshape(height, -1)
    channels = rows.shape[1] // width
    if rows.shape[1] < LANES:  # what is beyond the width is cut off again
        rows = np.pad(rows, ((0, 0), (0, LANES - rows.shape[1])))
    blurred = np.empty_like(rows)
    over_rows(_blur, height, rows.reshape(-1), height, rows.shape[1], width, channels, weights, blurred.reshape(-1))
    return np.ascontiguousarray(blurred[:, : width * channels]).reshape(image.shape)


@kernel
def _blur(
    first: int, last: int, rows: Any, height: int, stride: int, width: int, channels: int, weights: Any, blurred: Any
) -> None:
    steps = weights.size - 1
    margin, used = steps * channels, width * channels
    column = np.empty(stride + 2 * margin)  # sums over rows, the border repeated
    for y in range(first, last):
        for x0 in range(0, stride, LANES):
            x = min(x0, stride - LANES)
            total = weights[0] * to_doubles(load(rows, y * stride + x))
            for k in range(1, steps + 1):
                above = to_doubles(load(rows, max(y - k, 0) * stride + x))
                below = to_doubles(load(rows, min(y + k, height - 1) * stride + x))
                total = total + weights[k] * (above + below)
            store(column, margin + x, total)
        repeat_left(column, margin, steps, channels)
        repeat_right(column, margin + used, steps, channels)
        for x0 in range(0, stride, LANES):
            x = min(x0, stride - LANES)
            total = weights[0] * load(column, margin + x)
            for k in range(channels, margin + 1, channels):
                total = total + weights[k // channels] * (load(column, margin + x - k) + load(column, margin + x + k))
            store(blurred, y * stride + x, from_doubles(total))
