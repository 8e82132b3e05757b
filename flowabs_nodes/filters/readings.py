"""Readings of a picture of records at points near each of sixteen pixels: at the nearest pixel, or bilinearly.

Where to read is written down for many readings (:class:`Points`) before the first is taken, so that they need not wait
for each other. ``bilinear`` is None or not, as ``alpha`` in :mod:`~flowabs_nodes.filters.similarity`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from flowabs_nodes.filters.blocks import inline
from flowabs_nodes.filters.points import Frame, between, nearest
from flowabs_nodes.filters.similarity import TINY, Color
from flowabs_nodes.filters.vector import (
    LANES,
    inlined,
    load,
    quads_at,
    scratch,
    select,
    soon_read,
    soon_written,
    store,
)

MOST = 32  # readings that are written down, of sixteen pixels each

_AHEAD = 128  # pixels: what is fetched while these are worked on


class Points(NamedTuple):
    """Of each reading, where the record is, and how far beyond its pixel the point."""

    place: Any
    fx: Any
    fy: Any


class Around(NamedTuple):
    """A picture four times: from its beginning, a pixel further to the right, a row further below, and both."""

    here: Any
    right: Any
    below: Any
    beyond: Any


@inline
def new_points() -> Points:
    return Points(scratch(np.int32, 32), scratch(np.float32, 32), scratch(np.float32, 32))


@inlined
def around(picture: Any, frame: Frame, size: int) -> Around:
    right = size if frame.width > 1 else 0
    below = size * frame.stride if frame.height > 1 else 0
    return Around(picture, picture[right:], picture[below:], picture[right + below :])


@inlined
def expect(picture: Any, smoothed: Any, x: int, y: int, below: int, frame: Frame, size: int) -> None:
    """Have fetched what is needed before long; ``below``: the first row that is not yet."""
    for k in range(0, LANES * size, LANES):
        soon_read(picture, size * (min(y + below, frame.height - 1) * frame.stride + x) + k)
        soon_written(smoothed, size * (y * frame.stride + x + _AHEAD) + k)


@inlined
def find(points: Points, at: int, dx: Any, dy: Any, x: int, y: int, frame: Frame, size: int, bilinear: Any) -> None:
    """Reading ``at`` / 16 is to be taken (dx, dy) from the pixels x .. x + 15 of row y."""
    if bilinear is None:
        columns, rows = nearest(dx, dy, x, y, frame)
        store(points.place, at, (rows * frame.stride + columns) * size)
    else:
        corner = between(dx, dy, x, y, frame)
        store(points.place, at, (corner.y * frame.stride + corner.x) * size)
        store(points.fx, at, corner.fx)
        store(points.fy, at, corner.fy)


@inlined
def read(pictures: Around, points: Points, at: int, bilinear: Any, alpha: Any) -> Color:
    """Bilinearly, colours count by how much is there of each."""
    if bilinear is None:
        l, a, b, covered = quads_at(pictures.here, points.place, at)  # noqa: E741
        return Color(l, a, b, covered)
    one, two = _weighted(pictures.here, points, at, alpha), _weighted(pictures.right, points, at, alpha)
    three, four = _weighted(pictures.below, points, at, alpha), _weighted(pictures.beyond, points, at, alpha)
    u, v = load(points.fx, at), load(points.fy, at)
    l = _blend(one.l, two.l, three.l, four.l, u, v)  # noqa: E741
    a = _blend(one.a, two.a, three.a, four.a, u, v)
    b = _blend(one.b, two.b, three.b, four.b, u, v)
    if alpha is None:
        return Color(l, a, b, one.alpha)
    covered = _blend(one.alpha, two.alpha, three.alpha, four.alpha, u, v)
    over = select(covered > TINY, 1.0 / covered, 0.0)
    return Color(over * l, over * a, over * b, covered)


@inlined
def _weighted(picture: Any, points: Points, at: int, alpha: Any) -> Color:
    l, a, b, covered = quads_at(picture, points.place, at)  # noqa: E741
    if alpha is None:
        return Color(l, a, b, covered)
    return Color(covered * l, covered * a, covered * b, covered)


@inlined
def _blend(one: Any, two: Any, three: Any, four: Any, u: Any, v: Any) -> Any:
    upper, lower = one + u * (two - one), three + u * (four - three)
    return upper + v * (lower - upper)
