"""Following the flow (section 3.3): Euler steps of one pixel from the centre, z <- z + t(z), both ways.

The tangent is read at the pixel nearest to z, and turned round when it disagrees with the last step: a flow has no
sign. A zero tangent stops the walk, z stays where it is. Walks go on past the border, along the tangents of the
border.

Offsets from the centre are summed in float64. What rounding decides is then what exact arithmetic on the float32
tangents would decide.

A step waits for the tangent that it is taken along. Many walks are under way at once, in scratch memory: all of them
advance, then all turn.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from flowabs_nodes.sampling.coords import Frame, nearest
from flowabs_nodes.simd.jit import inline
from flowabs_nodes.simd.lanes import LANES, inlined, same_doubles, select, to_doubles
from flowabs_nodes.simd.memory import load, load_pairs, pairs_at, scratch, soon_read, store

TOGETHER = 8  # walks of sixteen pixels each
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
