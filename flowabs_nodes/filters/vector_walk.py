"""Following the flow (section 3.3), sixteen walks at a time: the Euler steps of :mod:`~flowabs_nodes.filters.walk`.

An offset from the centre is kept modulo 8 in fixed point, 3 bits before the point and 29 behind: sums are exact, never
grow, and round half to even as the whole offset would. The pixel is counted apart, step by step: a step moves it by -1,
0 or 1 column and row, by 2 where one tie comes after another. For that a tangent must not be longer (:func:`fits`).
"""

from __future__ import annotations

from typing import Any, NamedTuple

from flowabs_nodes.filters.arguments import Array
from flowabs_nodes.filters.vector import (
    inlined,
    lane_numbers,
    load_pairs,
    maximum,
    minimum,
    pairs,
    same_ints,
    select,
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
