"""How well frames fit along the motion: motion in another convention leads away from a surface, not along with it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array, Float64
from flowabs_nodes.filters.motion.places import Path, addresses, place_of, sample_plane
from flowabs_nodes.sampling.coords import Raster
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.lanes import LANES, absolute, lane_indices, select, splat_doubles, splat_floats, to_doubles
from flowabs_nodes.simd.memory import address, load, store

#: A pixel moves if its place on the next frame, or on the one before, is farther away than this, in pixels.
MOVES = 0.5
#: The share of a frame's pixels that must move for the misfit to be measured.
ENOUGH = 0.01
#: How much worse than no motion at all it has to be before it counts as wrong: noise and occlusions cost a little.
WORSE = 1.1


class Misfit(NamedTuple):
    """Mean differences of the guide between a frame and its neighbours, in code values, over pixels that move.

    ``along`` the motion, and in the same pixels, ``still``.
    """

    along: float
    still: float

    @property
    def wrong(self) -> bool:
        """Return True where frames fit worse along the motion than without it."""
        return self.along > WORSE * self.still

    @classmethod
    def of(cls, sums: Float64, pixels: int) -> Misfit | None:
        """Return the misfit of sums (..., 3) over pixels that move: their number and both differences; None of few."""
        number, along, still = sums.reshape(-1, 3).sum(axis=0)
        return cls(along / number, still / number) if number > ENOUGH * pixels else None


@kernel
def measure_misfit(first: int, last: int, raster: Raster, path: Path, own: Array, there: Array, sums: Float64) -> None:
    """Write, for each of the rows ``first`` .. ``last`` - 1, what :meth:`Misfit.of` sums up, (H, 3).

    ``path`` leads to the places on the other frame, whose guide is ``there``.
    """
    stride, lanes = raster.stride, np.empty(LANES)
    path, own, there = addresses(path), address(own, 0), address(there, 0)
    for y in range(first, last):
        number = along = still = splat_doubles(0.0)
        for x0 in range(0, stride, LANES):
            x = min(x0, stride - LANES)
            pixel, at = y * stride + x, (y - first) * stride + x
            dx, dy, column = load(path.dx, at), load(path.dy, at), lane_indices() + x
            counts = (column >= x0) & (column < raster.width)  # each pixel once
            moves = counts & (dx * dx + dy * dy > MOVES * MOVES)  # a lost path, NaN, does not
            value, here = load(own, pixel), load(there, pixel)
            far = sample_plane(there, place_of(path, at, raster))
            number = number + to_doubles(select(moves, splat_floats(1.0), splat_floats(0.0)))
            along = along + to_doubles(select(moves, absolute(far - value), splat_floats(0.0)))
            still = still + to_doubles(select(moves, absolute(here - value), splat_floats(0.0)))
        for k, sum in enumerate((number, along, still)):
            store(lanes, 0, sum)
            sums[y, k] = lanes.sum()
