"""Readings of a picture of records at points near each of sixteen pixels: at the nearest pixel, or bilinearly.

Where to read is written down for many readings (:class:`Points`) before the first is taken, so that they need not wait
for each other. ``bilinear`` is None or not, as ``alpha`` in :mod:`~flowabs_nodes.filters.regions.merge.range_weights`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from flowabs_nodes.sampling.coords import Frame, between, nearest
from flowabs_nodes.simd.jit import inline
from flowabs_nodes.simd.lanes import LANES, inlined, select
from flowabs_nodes.simd.memory import load, octets_at, quads_at, scratch, soon_read, soon_written, store

TINY = np.float32(1e-20)  # an alpha from which colours can no longer be told
AHEAD = 128  # pixels: what is fetched while these are worked on


class Color(NamedTuple):
    """Of sixteen records. What is read of records of three has no alpha: what is there then means nothing."""

    l: Any  # noqa: E741
    a: Any
    b: Any
    alpha: Any


class Points(NamedTuple):
    """Of up to 64 readings, where the record is, and how far beyond its pixel the point."""

    place: Any
    fx: Any
    fy: Any


@inline
def new_points() -> Points:
    return Points(scratch(np.int32, 64), scratch(np.float32, 64), scratch(np.float32, 64))


@inlined
def row_below(frame: Frame, size: int) -> int:
    """From a record to the one below, if there is one."""
    return size * frame.stride if frame.height > 1 else 0


@inlined
def expect(picture: Any, smoothed: Any, x: int, y: int, below: int, frame: Frame, size: int) -> None:
    """Have fetched what is needed before long; ``below``: the first row that is not yet."""
    for k in range(0, LANES * size, LANES):
        soon_read(picture, size * (min(y + below, frame.height - 1) * frame.stride + x) + k)
        soon_written(smoothed, size * (y * frame.stride + x + AHEAD) + k)


@inlined
def find(points: Points, at: int, dx: Any, dy: Any, x: int, y: int, frame: Frame, size: int, bilinear: Any) -> None:
    """The reading at [at] is to be taken (dx, dy) from the pixels x .. x + 15 of row y."""
    if bilinear is None:
        columns, rows = nearest(dx, dy, x, y, frame)
        store(points.place, at, (rows * frame.stride + columns) * size)
    else:
        corner = between(dx, dy, x, y, frame)
        store(points.place, at, (corner.y * frame.stride + corner.x) * size)
        store(points.fx, at, corner.fx)
        store(points.fy, at, corner.fy)


@inlined
def read(picture: Any, below: int, points: Points, at: int, bilinear: Any, alpha: Any) -> Color:
    """Bilinearly, colours count by how much is there of each. ``below`` is :func:`row_below`."""
    if bilinear is None:
        l, a, b, covered = quads_at(picture, points.place, at)  # noqa: E741
        return Color(l, a, b, covered)
    u, v = load(points.fx, at), load(points.fy, at)
    upper, lower = _read_across(picture, points, at, u, alpha), _read_across(picture[below:], points, at, u, alpha)
    l, a, b = _mix(upper.l, lower.l, v), _mix(upper.a, lower.a, v), _mix(upper.b, lower.b, v)  # noqa: E741
    if alpha is None:
        return Color(l, a, b, upper.alpha)
    covered = _mix(upper.alpha, lower.alpha, v)
    over = select(covered > TINY, 1.0 / covered, 0.0)
    return Color(over * l, over * a, over * b, covered)


@inlined
def _read_across(picture: Any, points: Points, at: int, u: Any, alpha: Any) -> Color:
    """Between a pixel and the one to the right; colours times alpha."""
    l, a, b, c, d, e, f, g = octets_at(picture, points.place, at)  # noqa: E741
    if alpha is None:
        return Color(_mix(l, c, u), _mix(a, d, u), _mix(b, e, u), f)
    return Color(_mix(c * l, g * d, u), _mix(c * a, g * e, u), _mix(c * b, g * f, u), _mix(c, g, u))


@inlined
def _mix(one: Any, other: Any, share: Any) -> Any:
    return one + share * (other - one)
