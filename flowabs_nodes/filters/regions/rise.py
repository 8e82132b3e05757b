"""How steeply lightness rises, which decides where a step between levels is hard.

The rise is sigma |grad(G_sigma * L*)|: how far L* goes over the length sigma. It is the same for a picture of any size
whose sigma is scaled with it. The gradient is a 3x3 Sobel filter divided by 8; the border is repeated.
"""

from __future__ import annotations

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
    if width < LANES:  # more of the repeated border changes nothing but the columns that are cut off again
        wide = np.pad(lightness, [(0, 0), (0, LANES - width)], "edge")
        return np.ascontiguousarray(rise(wide, sigma, unit)[:, :width])
    rises, weights = np.empty((height, width), np.float32), np.float32(gaussian.half(sigma))
    over_rows(_rise, height, lightness.reshape(-1), height, width, weights, np.float32(unit * sigma), rises.reshape(-1))
    return rises


@kernel
def _rise(
    first: int, last: int, lightness: Array, height: int, width: int, weights: Array, factor: float, rises: Array
) -> None:
    """Write the rows ``first`` .. ``last`` - 1 of ``factor`` |grad(G * L)|; both pictures are flattened."""
    column = np.empty(width + 2 * (weights.size - 1), np.float32)
    rows = np.empty((3, width + 2), np.float32)  # of the blurred picture, with the border repeated once
    for y in range(first - 1, first + 1):
        _blur_row(lightness, height, width, weights, y, column, rows[y % 3])
    for y in range(first, last):
        _blur_row(lightness, height, width, weights, y + 1, column, rows[(y + 1) % 3])
        above, here, below = rows[(y - 1) % 3], rows[y % 3], rows[(y + 1) % 3]
        for x0 in range(0, width, LANES):
            x = min(x0, width - LANES)
            a, b, c = load(above, x), load(above, x + 1), load(above, x + 2)
            p, q, r = load(below, x), load(below, x + 1), load(below, x + 2)
            gx = (c - a) + (r - p) + 2.0 * (load(here, x + 2) - load(here, x))
            gy = (p - a) + (r - c) + 2.0 * (q - b)
            store(rises, y * width + x, sqrt(gx * gx + gy * gy) * (0.125 * factor))


@inlined
def _blur_row(lightness: Array, height: int, width: int, weights: Array, y: int, column: Array, row: Array) -> None:
    """Write row y of G * L to ``row``, W + 2 items; beyond the picture it is the nearest row inside.

    ``column`` is memory for the row blurred along y alone, with the Gaussian's reach to either side.
    """
    steps = weights.size - 1
    y = min(max(y, 0), height - 1)
    for x0 in range(0, width, LANES):
        x = min(x0, width - LANES)
        total = weights[0] * load(lightness, y * width + x)
        for k in range(1, steps + 1):
            above, below = max(y - k, 0), min(y + k, height - 1)
            total = total + weights[k] * (load(lightness, above * width + x) + load(lightness, below * width + x))
        store(column, steps + x, total)
    repeat_left(column, steps, steps, 1)
    repeat_right(column, steps + width, steps, 1)
    for x0 in range(0, width, LANES):
        x = min(x0, width - LANES)
        total = weights[0] * load(column, steps + x)
        for k in range(1, steps + 1):
            total = total + weights[k] * (load(column, steps + x - k) + load(column, steps + x + k))
        store(row, 1 + x, total)
    repeat_left(row, 1, 1, 1)
    repeat_right(row, 1 + width, 1, 1)
