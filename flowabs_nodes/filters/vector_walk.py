"""Following the flow (section 3.3), sixteen walks at a time: the Euler steps of :mod:`~flowabs_nodes.filters.walk`.

An offset from the centre is kept modulo 8 in fixed point, 3 bits before the point and 29 behind: sums are exact, never
grow, and round half to even as the whole offset would. The pixel is counted apart, step by step: a step moves it by -1,
0 or 1 column and row, by 2 where one tie comes after another. For that a tangent must not be longer (:func:`fits`).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from flowabs_nodes.filters.arguments import Array
from flowabs_nodes.filters.blocks import inline
from flowabs_nodes.filters.points import Frame, nearest
from flowabs_nodes.filters.vector import (
    LANES,
    inlined,
    lane_numbers,
    load,
    load_pairs,
    maximum,
    minimum,
    pairs,
    pairs_at,
    same_doubles,
    same_ints,
    scratch,
    select,
    soon_read,
    store,
    to_doubles,
    to_ints,
)

_POINT = 29
_ONE = 1 << _POINT
_ONE_FLOAT = float(_ONE)


class Walk(NamedTuple):
    """Where sixteen walks are."""

    x: Any  # the pixel nearest to z; past the border walks go on
    y: Any
    dx: Any  # the offset of z from the centre, modulo 8 in fixed point
    dy: Any
    tx: Any  # t(z), the way the walk goes on
    ty: Any


@inlined
def start(flow: Any, x: int, y: int, width: int, way: int) -> Walk:
    """At the centres x .. x + 15 of row y, to go along the tangent there (``way`` 0) or against it (1)."""
    tx, ty = load_pairs(flow, 2 * (y * width + x))
    if way == 1:
        tx, ty = -tx, -ty
    return Walk(lane_numbers() + x, same_ints(y), same_ints(0), same_ints(0), tx, ty)


@inlined
def step(walk: Walk, flow: Any, width: int, height: int) -> Walk:
    """One step further: new offsets, the nearest pixel, and the tangent there, turned to go on the same way."""
    dx, dy = walk.dx + to_ints(walk.tx * _ONE_FLOAT), walk.dy + to_ints(walk.ty * _ONE_FLOAT)
    x = walk.x + _difference(rounded(dx), rounded(walk.dx))
    y = walk.y + _difference(rounded(dy), rounded(walk.dy))
    tx, ty = pairs(flow, 2 * inside(x, y, width, height))
    against = tx * walk.tx + ty * walk.ty < 0.0
    return Walk(x, y, dx, dy, select(against, -tx, tx), select(against, -ty, ty))


@inlined
def inside(x: Any, y: Any, width: int, height: int) -> Any:
    """The number of the pixel (x, y), of the border's nearest where it is outside the picture."""
    return minimum(maximum(y, 0), height - 1) * width + minimum(maximum(x, 0), width - 1)


@inlined
def rounded(d: Any) -> Any:
    """An offset to the nearest whole number modulo 8, half to even."""
    return (d + (((d >> _POINT) & 1) + (_ONE // 2 - 1))) >> _POINT


@inlined
def _difference(a: Any, b: Any) -> Any:
    """a - b of numbers modulo 8: -4 .. 3."""
    return ((a - b) << _POINT) >> _POINT


def fits(flow: Array) -> bool:
    """Whether tangents are about unit vectors (a little longer they do no harm)."""
    return bool(flow.min() > -2 and flow.max() < 2)


# Many walks at once. ------------------------------------------------------------------------------------------------

TOGETHER = 8  # walks: enough of them to work on while the tangents of others are under way
ALL = TOGETHER * LANES


class Walks(NamedTuple):
    """Where the walks of 64 pixels of a row are, both ways.

    Walk k = 0, 2, 4, 6 goes along the tangents of sixteen pixels, k + 1 against them; at [16 k] is what is theirs.
    """

    pixel: Any  # the number of the one nearest to z
    dx: Any  # z - x, the offset from the centre
    dy: Any
    tx: Any  # t(z), the way the walk goes on
    ty: Any


@inline
def new_walks() -> Walks:
    return Walks(
        scratch(np.int32, TOGETHER),
        scratch(np.float64, TOGETHER),
        scratch(np.float64, TOGETHER),
        scratch(np.float32, TOGETHER),
        scratch(np.float32, TOGETHER),
    )


@inlined
def column(x0: int, at: int, frame: Frame) -> int:
    """The first of the sixteen columns whose walk is at [at]; where the row ends, the last ones are walked twice."""
    return min(x0 + at // (2 * LANES) * LANES, frame.stride - LANES)


@inlined
def set_out(walks: Walks, flow: Any, x0: int, y: int, frame: Frame) -> None:
    """From the centres x0 .. x0 + 63 of row y. ``flow`` is complex64: a pair of floats for each pixel."""
    for at in range(0, ALL, 2 * LANES):
        tx, ty = load_pairs(flow, y * frame.stride + column(x0, at, frame))
        _set_out(walks, at, tx, ty)
        _set_out(walks, at + LANES, -tx, -ty)


@inlined
def expect_tangents(flow: Any, x: int, y: int, below: int, frame: Frame) -> None:
    """Have those fetched that walks will come to before long; ``below``: the first row that is not yet."""
    pixel = min(y + below, frame.height - 1) * frame.stride + x
    soon_read(flow, pixel)
    soon_read(flow, pixel + LANES // 2)


@inlined
def _set_out(walks: Walks, at: int, tx: Any, ty: Any) -> None:
    store(walks.dx, at, same_doubles(0.0))
    store(walks.dy, at, same_doubles(0.0))
    store(walks.tx, at, tx)
    store(walks.ty, at, ty)


@inlined
def advance(walks: Walks, at: int, x: int, y: int, frame: Frame) -> Any:
    """z + t(z) for the sixteen walks at [at]; returns column and row of the pixels nearest to it."""
    dx, dy = load(walks.dx, at) + to_doubles(load(walks.tx, at)), load(walks.dy, at) + to_doubles(load(walks.ty, at))
    store(walks.dx, at, dx)
    store(walks.dy, at, dy)
    columns, rows = nearest(dx, dy, x, y, frame)
    store(walks.pixel, at, rows * frame.stride + columns)
    return columns, rows


@inlined
def turn(walks: Walks, flow: Any) -> None:
    """After a step of all the walks, before the next: the tangents at z, turned to go on the same way."""
    for at in range(0, ALL, LANES):
        tx, ty = pairs_at(flow, walks.pixel, at)
        against = tx * load(walks.tx, at) < -(ty * load(walks.ty, at))  # right also where a sum would round
        store(walks.tx, at, select(against, -tx, tx))
        store(walks.ty, at, select(against, -ty, ty))
