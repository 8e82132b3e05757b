"""Points near sixteen pixels, by their offsets in float64: the nearest pixel, or the four around.

Points may lie anywhere: their coordinates are clamped to the picture, which repeats its border. Offsets, not
coordinates, are rounded, half to even, so that how a point rounds does not depend on where its pixel lies.

In memory rows of pictures have at least sixteen pixels, which is what vectors take: :func:`padded_rows`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.simd.jit import inlined
from flowabs_nodes.simd.lanes import LANES, from_doubles, lane_indices, maximum, minimum, rint, round_to_ints, select


class Raster(NamedTuple):
    """A picture's size, and the length of its rows in memory."""

    width: int
    height: int
    stride: int


class BilinearCoords(NamedTuple):
    """Where points are: the upper left pixel of the four around each, and how far beyond it they are, 0..1."""

    x: Any
    y: Any
    fx: Any
    fy: Any


def raster_of(picture: npt.NDArray[Any]) -> Raster:
    height, width = picture.shape[:2]
    return Raster(width, height, max(width, LANES))


def padded_rows(picture: npt.NDArray[Any], raster: Raster) -> npt.NDArray[Any]:
    """``picture`` in one dimension, rows that are too short filled up with zeros."""
    missing = raster.stride - raster.width
    if missing:
        picture = np.pad(picture, [(0, 0), (0, missing)] + [(0, 0)] * (picture.ndim - 2))
    return picture.reshape(-1)


@inlined
def nearest_pixels(dx: Any, dy: Any, x: int, y: int, raster: Raster) -> Any:
    """Column and row of the pixel nearest to each point that is (dx, dy) from pixels x .. x + 15 of row y."""
    columns, rows = round_to_ints(dx) + (lane_indices() + x), round_to_ints(dy) + y
    return minimum(maximum(columns, 0), raster.width - 1), minimum(maximum(rows, 0), raster.height - 1)


@inlined
def bilinear_coords(dx: Any, dy: Any, x: int, y: int, raster: Raster) -> BilinearCoords:
    left, fx = _floor_and_fraction(dx, lane_indices() + x, raster.width - 2)
    top, fy = _floor_and_fraction(dy, lane_indices() * 0 + y, raster.height - 2)
    return BilinearCoords(left, top, fx, fy)


@inlined
def _floor_and_fraction(d: Any, start: Any, last: int) -> Any:
    """The whole part of start + d, at least 0 and at most ``last``, and the rest; of whole numbers it may be 1."""
    below = rint(d - 0.5)
    rest, whole = from_doubles(d - below), round_to_ints(below) + start
    beyond = 1.0 if last >= 0 else 0.0  # in a picture of one column there is nothing to the right
    rest = select(whole < 0, 0.0, select(whole > last, beyond, rest))
    return maximum(minimum(whole, last), 0), rest
