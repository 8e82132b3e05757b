"""Gaussian blur: separable, the border repeated."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array, Float64
from flowabs_nodes.filters import gaussian, validate
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.border import repeat_left, repeat_right
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.lanes import LANES, from_doubles, to_doubles
from flowabs_nodes.simd.memory import load, store


def blur(image: npt.ArrayLike, sigma: float = 1.0) -> Array:
    """Blur each channel with a Gaussian, the border repeated.

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


class RowsShape(NamedTuple):
    """The shape of an image (H, W, C) whose rows are longer in memory than W C items."""

    height: int
    width: int
    channels: int
    stride: int  # items from one row to the next, at least sixteen


def separable(image: Array, weights: Float64, result: Array | None = None) -> Array:
    """Return the weighted sum over rows, then columns, of (H, W) or (H, W, C) float32; summed in float64.

    ``weights`` are those of the offsets 0, 1 .. to either side. The sum is written to ``result`` where that is given,
    C-contiguous float32 of the same shape.
    """
    height, width = image.shape[:2]
    rows = image.reshape(height, -1)
    channels = rows.shape[1] // width
    if rows.shape[1] < LANES:  # the padding is cut off again
        rows = np.pad(rows, ((0, 0), (0, LANES - rows.shape[1])))
    wide_enough = rows.shape[1] == width * channels
    blurred = np.empty_like(rows) if result is None or not wide_enough else result.reshape(height, -1)
    shape = RowsShape(height, width, channels, rows.shape[1])
    over_rows(_blur, height, rows.reshape(-1), shape, weights, blurred.reshape(-1))
    if wide_enough:
        return blurred.reshape(image.shape)
    narrow = np.ascontiguousarray(blurred[:, : width * channels]).reshape(image.shape)
    if result is None:
        return narrow
    result[:] = narrow
    return result


@kernel
def _blur(first: int, last: int, rows: Array, shape: RowsShape, weights: Float64, blurred: Array) -> None:
    """Write the rows ``first`` .. ``last`` - 1 of the blurred image; ``rows`` and ``blurred`` are flattened."""
    height, width, channels, stride = shape
    steps = weights.size - 1
    margin, used = steps * channels, width * channels
    column = np.empty(stride + 2 * margin)  # weighted sums of each column's pixels, the border repeated
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
