"""Motion at silhouettes: the nearest pure pixel's, where a pixel mixes the motion of two surfaces.

A renderer filters its motion pass like its picture, so that the vector of a silhouette's pixel is a mean, which leads
neither along with the surface in front nor with the one behind. Depth tells such pixels, and which side each is on.
"""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters.motion.convention import Steps
from flowabs_nodes.filters.motion.places import Pairs
from flowabs_nodes.sampling.coords import Raster
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.border import repeat_left, repeat_right
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.lanes import LANES, any_lane, maximum, minimum, select, splat_floats
from flowabs_nodes.simd.memory import load, store

#: A pixel is mixed where the depth of one of its eight neighbours differs by more than this share of the nearer one.
STEP = 0.03
#: How far from a mixed pixel a pure one is looked for, in pixels.
RADIUS = 3
#: The price of a pure pixel: of each 1 % of difference in depth, and of its squared distance in pixels.
PRICE_OF_DEPTH, PRICE_OF_DISTANCE = 1.0, 0.05


def with_pure_motion(steps: Steps, depth: Array, raster: Raster) -> Steps:
    """Return the steps with those of mixed pixels taken from pure ones; ``steps`` is written to.

    A pure pixel's depth, ``depth`` is (H x stride,), is near that of all its neighbours. Of the pure ones within 3
    pixels that is taken which is nearest, by depth and by distance; where there is none the step stays.
    """
    mixed = np.empty(depth.size, np.float32)
    over_rows(_find_mixed, raster.height, depth, raster, mixed)
    over_rows(_take_pure, raster.height, depth, mixed, raster, *steps)
    return steps


@kernel
def _find_mixed(first: int, last: int, depth: Array, raster: Raster, mixed: Array) -> None:
    """Write 1 for the mixed pixels of the rows ``first`` .. ``last`` - 1, and 0 for the others."""
    width, height, stride = raster
    low, high = np.empty(stride + 2, np.float32), np.empty(stride + 2, np.float32)  # of three rows, one pixel ahead
    for y in range(first, last):
        above, below = max(y - 1, 0) * stride, min(y + 1, height - 1) * stride
        for x0 in range(0, stride, LANES):
            x = min(x0, stride - LANES)
            a, b, c = load(depth, above + x), load(depth, y * stride + x), load(depth, below + x)
            store(low, 1 + x, minimum(minimum(a, b), c))
            store(high, 1 + x, maximum(maximum(a, b), c))
        for column in (low, high):
            repeat_left(column, 1, 1, 1)
            repeat_right(column, 1 + width, 1, 1)
        for x0 in range(0, stride, LANES):
            x = min(x0, stride - LANES)
            z = load(depth, y * stride + x)
            nearest = minimum(minimum(load(low, x), load(low, x + 1)), load(low, x + 2))
            farthest = maximum(maximum(load(high, x), load(high, x + 1)), load(high, x + 2))
            differs = (farthest > (1.0 + STEP) * z) | (z > (1.0 + STEP) * nearest)
            store(mixed, y * stride + x, select(differs, splat_floats(1.0), splat_floats(0.0)))


@kernel
def _take_pure(
    first: int, last: int, depth: Array, mixed: Array, raster: Raster, previous: Pairs, following: Pairs
) -> None:
    """Give the mixed pixels of the rows ``first`` .. ``last`` - 1 the steps of pure ones, which nobody writes to."""
    width, height, stride = raster
    for y in range(first, last):
        for x0 in range(0, width, LANES):
            if not any_lane(load(mixed, y * stride + min(x0, stride - LANES)) > 0.0):
                continue
            for x in range(x0, min(x0 + LANES, width)):
                pixel = y * stride + x
                if mixed[pixel] == 0:
                    continue
                z, best, lowest = depth[pixel], -1, np.float32(np.inf)
                for v in range(max(y - RADIUS, 0), min(y + RADIUS, height - 1) + 1):
                    for u in range(max(x - RADIUS, 0), min(x + RADIUS, width - 1) + 1):
                        other = v * stride + u
                        if mixed[other] > 0:
                            continue
                        apart = abs(depth[other] - z) / max(abs(z), 1e-20)
                        squared = (u - x) * (u - x) + (v - y) * (v - y)
                        price = np.float32(100 * PRICE_OF_DEPTH * apart + PRICE_OF_DISTANCE * squared)
                        if price < lowest:
                            lowest, best = price, other
                if best >= 0:
                    previous[pixel], following[pixel] = previous[best], following[best]
