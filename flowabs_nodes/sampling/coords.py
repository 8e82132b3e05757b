"""Coordinates of sample points near sixteen pixels: the nearest pixel of each point, or the four pixels around it.

A point is given by its offset (dx, dy) from the centre of its pixel, in pixels, x to the right and y down, as float64.
It may lie outside the picture: coordinates are clamped, as if the border pixels were repeated. It is the offset that is
rounded, half to even, not the coordinate: how a point rounds does not depend on the position of its pixel.

In memory the rows of a picture have at least sixteen pixels, so that each holds a vector: :func:`padded_rows`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.simd.jit import inlined
from flowabs_nodes.simd.lanes import (
    LANES,
    Doubles,
    Floats,
    Ints,
    from_doubles,
    lane_indices,
    maximum,
    minimum,
    rint,
    round_to_ints,
    select,
)


class Raster(NamedTuple):
    """The size of a picture and the length of its rows in memory, all in pixels."""

    width: int
    height: int
    stride: int  # from one row to the next: the width, but at least sixteen


class BilinearCoords(NamedTuple):
    """The four pixels around each of sixteen points: the upper left one, and the point's distance from it, 0 to 1."""

    x: Ints  # column and row of the upper left pixel
    y: Ints
    fx: Floats  # distance to the right and down, in pixels
    fy: Floats


def raster_of(picture: npt.NDArray[Any]) -> Raster:
    """Return the raster of a picture (H, W, ...) once its rows are padded."""
    height, width = picture.shape[:2]
    return Raster(width, height, max(width, LANES))


def padded_rows(picture: npt.NDArray[Any], raster: Raster) -> npt.NDArray[Any]:
    """Return ``picture`` (H, W, ...) flattened, (H x stride x ...,), its rows filled up with zeros to the stride."""
    missing = raster.stride - raster.width
    if missing:
        picture = np.pad(picture, [(0, 0), (0, missing)] + [(0, 0)] * (picture.ndim - 2))
    return picture.reshape(-1)


@inlined
def nearest_pixels(dx: Doubles, dy: Doubles, x: int, y: int, raster: Raster) -> tuple[Ints, Ints]:
    """Return column and row of the pixel nearest to each point (dx, dy) away from the pixels x .. x + 15 of row y."""
    columns, rows = round_to_ints(dx) + (lane_indices() + x), round_to_ints(dy) + y
    return clamped_columns(columns, raster), clamped_rows(rows, raster)


@inlined
def clamped_columns(columns: Ints, raster: Raster) -> Ints:
    """Return columns, clamped to the picture."""
    return minimum(maximum(columns, 0), raster.width - 1)


@inlined
def clamped_rows(rows: Ints, raster: Raster) -> Ints:
    """Return rows, clamped to the picture."""
    return minimum(maximum(rows, 0), raster.height - 1)


@inlined
def bilinear_coords(dx: Doubles, dy: Doubles, x: int, y: int, raster: Raster) -> BilinearCoords:
    """Return the four pixels around each point (dx, dy) away from the pixels x .. x + 15 of row y."""
    left, fx = _floor_and_fraction(dx, lane_indices() + x, raster.width - 2)
    top, fy = _floor_and_fraction(dy, lane_indices() * 0 + y, raster.height - 2)
    return BilinearCoords(left, top, fx, fy)


@inlined
def _floor_and_fraction(d: Doubles, start: Ints, last: int) -> tuple[Ints, Floats]:
    """Return floor(start + d) clamped to 0 .. ``last``, and the fraction beyond it, 0 to 1.

    ``last`` is the last column (or row) that has a neighbour after it. If start + d is whole, the results may also be
    the number before it and 1.
    """
    below = rint(d - 0.5)
    fraction, whole = from_doubles(d - below), round_to_ints(below) + start
    after_last = 1.0 if last >= 0 else 0.0  # a picture of one column has nothing to the right of it
    fraction = select(whole < 0, 0.0, select(whole > last, after_last, fraction))
    return maximum(minimum(whole, last), 0), fraction
