"""Points near sixteen pixels, by their offsets in float64: the nearest pixel, or the four around.

Points may lie anywhere: their coordinates are clamped to the picture, which repeats its border. Offsets, not
coordinates, are rounded, half to even, so that how a point rounds does not depend on where its pixel lies.

In memory rows of pictures have at least sixteen pixels, which is what vectors take: :func:`padded`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.simd.lanes import (
    LANES,
    from_doubles,
    inlined,
    lane_numbers,
    maximum,
    minimum,
    nearest_ints,
    rint,
    select,
)


class Frame(NamedTuple):
    """A picture's size, and the length of its rows in memory."""

    width: int
    height: int
    stride: int


class Between(NamedTuple):
    """Where points are: the upper left pixel of the four around each, and how far beyond it they are, 0..1."""

    x: Any
    y: Any
    fx: Any
    fy: Any


def frame_of(picture: npt.NDArray[Any]) -> Frame:
    height, width = picture.shape[:2]
    return Frame(width, height, max(width, LANES))


def padded(picture: npt.NDArray[Any], frame: Frame) -> npt.NDArray[Any]:
    """``picture`` in one dimension, rows that are too short filled up with zeros."""
    missing = frame.stride - frame.width
    if missing:
        picture = np.pad(picture, [(0, 0), (0, missing)] + [(0, 0)] * (picture.ndim - 2))
    return picture.reshape(-1)


@inlined
def nearest(dx: Any, dy: Any, x: int, y: int, frame: Frame) -> Any:
    """Column and row of the pixel nearest to each point that is (dx, dy) from pixels x .. x + 15 of row y."""
    columns, rows = nearest_ints(dx) + (lane_numbers() + x), nearest_ints(dy) + y
    return minimum(maximum(columns, 0), frame.width - 1), minimum(maximum(rows, 0), frame.height - 1)


@inlined
def between(dx: Any, dy: Any, x: int, y: int, frame: Frame) -> Between:
    left, fx = _apart(dx, lane_numbers() + x, frame.width - 2)
    top, fy = _apart(dy, lane_numbers() * 0 + y, frame.height - 2)
    return Between(left, top, fx, fy)


@inlined
def _apart(d: Any, start: Any, last: int) -> Any:
    """The whole part of start + d, at least 0 and at most ``last``, and the rest; of whole numbers it may be 1."""
    below = rint(d - 0.5)
    rest, whole = from_doubles(d - below), nearest_ints(below) + start
    beyond = 1.0 if last >= 0 else 0.0  # in a picture of one column there is nothing to the right
    rest = select(whole < 0, 0.0, select(whole > last, beyond, rest))
    return maximum(minimum(whole, last), 0), rest
