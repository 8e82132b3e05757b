"""The motion pass's convention, in this one place: from its four channels to steps in the picture.

A motion pass holds X, Y, Z, W in pixels, y up (:mod:`flowabs_nodes.port_types`). X, Y lead to the place of a pixel's
surface on the previous frame; on the next it is where -Z, -W lead. Here x goes right and y down:

    to the previous frame   (x, y) -> (x + X, y - Y)
    to the next frame       (x, y) -> (x - Z, y + W)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters.motion.places import Pairs
from flowabs_nodes.sampling.coords import Raster, padded_rows, raster_of
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.lanes import LANES
from flowabs_nodes.simd.memory import load_quads, store_pairs

#: A vector this long, or longer, stands for no surface: it leads out of every picture.
NOWHERE = 1e9


class Steps(NamedTuple):
    """From each pixel to the place of its surface one frame before and one frame after: x right, y down, in pixels.

    Both are (H x stride,) complex64. A step that leads out of the picture, or is NaN, leads nowhere.
    """

    previous: Pairs
    following: Pairs


def steps_of(motion: Array, raster: Raster, *, previous: bool = True, following: bool = True) -> Steps:
    """Return the steps of a motion pass (H, W, 4), as its vectors say; of no pixels what is not asked for."""
    pixels = raster.height * raster.stride
    steps = Steps(*(np.empty(pixels if asked else 0, np.complex64) for asked in (previous, following)))
    floats = [each.view(np.float32) for each in steps]
    over_rows(_turn, raster.height, padded_rows(motion, raster), raster.stride, *floats)
    return steps


def motion_of(previous: Array, following: Array) -> Array:
    """Return the motion pass (H, W, 4) of steps to the previous and to the next frame, each (H, W, 2), y down."""
    flips = np.array([1, -1], np.float32)
    return np.concatenate([previous * flips, 0 - following * flips], axis=2)


def lost_pixels(motion: Array) -> int:
    """Return how many pixels of a motion pass (H, W, 4) have a vector that leads nowhere: NaN, Inf, or 1e9 and more."""
    raster = raster_of(motion)
    return sum(over_rows(_count_lost, raster.height, padded_rows(motion, raster), raster))


@kernel
def _turn(first: int, last: int, motion: Array, stride: int, previous: Array, following: Array) -> None:
    """Write both steps of the rows ``first`` .. ``last`` - 1; all arrays are flattened, of ``stride`` pixels a row."""
    for y in range(first, last):
        for x0 in range(0, stride, LANES):
            pixel = y * stride + min(x0, stride - LANES)
            x, y_up, z, w = load_quads(motion, 4 * pixel)
            if previous.size > 0:
                store_pairs(previous, 2 * pixel, (x, -y_up))
            if following.size > 0:
                store_pairs(following, 2 * pixel, (-z, w))


@kernel
def _count_lost(first: int, last: int, motion: Array, raster: Raster) -> int:
    """Return how many pixels of the rows ``first`` .. ``last`` - 1 have a vector that leads nowhere."""
    count = 0
    for y in range(first, last):
        for x in range(raster.width):
            at = 4 * (y * raster.stride + x)
            known = abs(motion[at]) < NOWHERE and abs(motion[at + 1]) < NOWHERE  # NaN is not
            count += not (known and abs(motion[at + 2]) < NOWHERE and abs(motion[at + 3]) < NOWHERE)
    return count
