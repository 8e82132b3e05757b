"""Motion at silhouettes: the nearest pure pixel's, where a pixel mixes the motion of two surfaces.

A renderer filters its motion pass like its picture, so that the vector of a silhouette's pixel is a mean, which leads
neither along with the surface in front nor with the one behind. Depth tells such pixels, and which side each is on.
"""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters.motion.convention import Steps
from flowabs_nodes.filters.motion.places import Pairs
from flowabs_nodes.filters.motion.surface import known
from flowabs_nodes.sampling.coords import Raster
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.border import repeat_left, repeat_right
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import (
    LANES,
    absolute,
    any_lane,
    from_doubles,
    maximum,
    minimum,
    select,
    splat_floats,
    splat_ints,
    to_doubles,
)
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
    over_rows(_take_pure, raster.height, depth, raster, *steps)
    return steps


@kernel
def _take_pure(first: int, last: int, depth: Array, raster: Raster, previous: Pairs, following: Pairs) -> None:
    """Give the mixed pixels of the rows ``first`` .. ``last`` - 1 the steps of pure ones, which nobody writes to."""
    width, height, stride = raster
    top, bottom = max(first - RADIUS, 0), min(last + RADIUS, height)
    across = stride + 2 * RADIUS
    pure = np.full((bottom - top) * across, np.float32(np.nan))
    _find_pure(top, bottom, depth, raster, pure)
    ways = np.empty(LANES, np.int32)  # from pixels to those whose steps they take
    for y in range(first, last):
        for x0 in range(0, width, LANES):
            x = min(x0, stride - LANES)
            pixel, own = y * stride + x, (y - top) * across + RADIUS + x
            itself = load(pure, own)
            mixed = select(itself == itself, splat_ints(0), splat_ints(1)) > 0
            if not any_lane(mixed):
                continue
            z, way = known(load(depth, pixel)), splat_ints(0)
            lowest, unit = splat_floats(np.inf), 100 * PRICE_OF_DEPTH / maximum(to_doubles(absolute(z)), 1e-20)
            for v in range(max(y - RADIUS, top) - y, min(y + RADIUS, bottom - 1) - y + 1):
                for u in range(-RADIUS, RADIUS + 1):
                    apart = to_doubles(absolute(load(pure, own + v * across + u) - z))  # NaN is no cheaper
                    price = from_doubles(unit * apart + PRICE_OF_DISTANCE * (u * u + v * v))
                    way = select(price < lowest, splat_ints(v * stride + u), way)
                    lowest = minimum(price, lowest)
            store(ways, 0, select(mixed, way, splat_ints(0)))
            for lane in range(x0 - x, min(LANES, width - x)):
                other = pixel + lane + ways[lane]
                if other == pixel + lane:
                    continue
                if previous.size > 0:
                    previous[pixel + lane] = previous[other]
                if following.size > 0:
                    following[pixel + lane] = following[other]


@inlined
def _find_pure(top: int, bottom: int, depth: Array, raster: Raster, pure: Array) -> None:
    """Write the depths of the pure pixels of the rows ``top`` .. ``bottom`` - 1, and NaN for mixed ones.

    The rows of ``pure`` have ``RADIUS`` more pixels on either side, which are left as they are.
    """
    width, height, stride = raster
    low, high = np.empty(stride + 2, np.float32), np.empty(stride + 2, np.float32)  # of three rows, one pixel ahead
    for y in range(top, bottom):
        above, below = max(y - 1, 0) * stride, min(y + 1, height - 1) * stride
        for x0 in range(0, stride, LANES):
            x = min(x0, stride - LANES)
            a, b, c = known(load(depth, above + x)), known(load(depth, y * stride + x)), known(load(depth, below + x))
            store(low, 1 + x, minimum(minimum(a, b), c))
            store(high, 1 + x, maximum(maximum(a, b), c))
        for column in (low, high):
            repeat_left(column, 1, 1, 1)
            repeat_right(column, 1 + width, 1, 1)
        row = (y - top) * (stride + 2 * RADIUS) + RADIUS
        for x0 in range(0, stride, LANES):
            x = min(x0, stride - LANES)
            z = known(load(depth, y * stride + x))
            nearest = minimum(minimum(load(low, x), load(low, x + 1)), load(low, x + 2))
            farthest = maximum(maximum(load(high, x), load(high, x + 1)), load(high, x + 2))
            differs = (farthest > (1.0 + STEP) * z) | (z > (1.0 + STEP) * nearest)
            store(pure, row + x, select(differs, splat_floats(np.nan), z))
        pure[row + width : row + stride] = np.nan  # beyond the picture's border
