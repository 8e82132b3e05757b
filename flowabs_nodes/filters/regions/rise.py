"""How steeply lightness rises, which decides where a step between levels is hard.

The rise is sigma |grad(G_sigma * L*)|: how far L* goes over the length sigma. It is the same for a picture of any size
whose sigma is scaled with it. The gradient is a 3x3 Sobel filter divided by 8; the border is repeated.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters import gaussian
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.border import repeat_left, repeat_right
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, sqrt
from flowabs_nodes.simd.memory import load, store


def rise(lightness: Array, sigma: float, unit: float = 1.0) -> Array:
    """Return the rise of each pixel, (H, W) float32.

    Parameters
    ----------
    lightness
        (H, W) float32.
    sigma
        Standard deviation of the Gaussian in pixels, above 0; cut at ceil(3 sigma).
    unit
        What the result is multiplied by: 1 / 2.55 makes L* of code values.
    """
    height, width = lightness.shape
    if width < LANES:  # the columns that repeat the border are cut off again
        lightness = np.pad(lightness, [(0, 0), (0, LANES - width)], "edge")
    rises, weights = np.empty_like(lightness), np.float32(gaussian.half(sigma))
    shape = RowsShape(height, width, lightness.shape[1])
    over_rows(_rise, height, lightness.reshape(-1), shape, weights, np.float32(unit * sigma), rises.reshape(-1))
    return np.ascontiguousarray(rises[:, :width])


class RowsShape(NamedTuple):
    """The shape of a picture whose rows are longer in memory than its width where that is less than sixteen."""

    height: int
    width: int
    stride: int  # items from one row to the next


@kernel
def _rise(
    first: int, last: int, lightness: Array, shape: RowsShape, weights: Array, factor: float, rises: Array
) -> None:
    """Write the rows ``first`` .. ``last`` - 1 of ``factor`` |grad(G * L)|; both pictures are flattened."""
    stride = shape.stride
    column = np.empty(stride + 2 * (weights.size - 1), np.float32)
    rows = np.empty((3, stride + 2), np.float32)  # of the blurred picture, with the border repeated
    for y in range(first - 1, first + 1):
        _blur_row(lightness, shape, weights, y, column, rows[y % 3])
    for y in range(first, last):
        _blur_row(lightness, shape, weights, y + 1, column, rows[(y + 1) % 3])
        above, here, below = rows[(y - 1) % 3], rows[y % 3], rows[(y + 1) % 3]
        for x0 in range(0, stride, LANES):
            x = min(x0, stride - LANES)
            a, b, c = load(above, x), load(above, x + 1), load(above, x + 2)
            p, q, r = load(below, x), load(below, x + 1), load(below, x + 2)
            gx = (c - a) + (r - p) + 2.0 * (load(here, x + 2) - load(here, x))
            gy = (p - a) + (r - c) + 2.0 * (q - b)
            store(rises, y * stride + x, sqrt(gx * gx + gy * gy) * (0.125 * factor))


@inlined
def _blur_row(lightness: Array, shape: RowsShape, weights: Array, y: int, column: Array, row: Array) -> None:
    """Write row y of G * L to ``row``, from its second item on; beyond the picture it is the nearest row inside.

    ``column`` is memory for the row blurred along y alone, with the Gaussian's reach to either side.
    """
    height, width, stride = shape
    steps = weights.size - 1
    y = min(max(y, 0), height - 1)
    for x0 in range(0, stride, LANES):
        x = min(x0, stride - LANES)
        total = weights[0] * load(lightness, y * stride + x)
        for k in range(1, steps + 1):
            above, below = max(y - k, 0), min(y + k, height - 1)
            total = total + weights[k] * (load(lightness, above * stride + x) + load(lightness, below * stride + x))
        store(column, steps + x, total)
    repeat_left(column, steps, steps, 1)
    repeat_right(column, steps + stride, steps, 1)
    for x0 in range(0, stride, LANES):
        x = min(x0, stride - LANES)
        total = weights[0] * load(column, steps + x)
        for k in range(1, steps + 1):
            total = total + weights[k] * (load(column, steps + x - k) + load(column, steps + x + k))
        store(row, 1 + x, total)
    repeat_left(row, 1, 1, 1)
    repeat_right(row, 1 + width, stride - width + 1, 1)
