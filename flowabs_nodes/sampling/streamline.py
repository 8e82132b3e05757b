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

from flowabs_nodes.sampling.coords import Raster, nearest_pixels
from flowabs_nodes.simd.jit import inline, inlined
from flowabs_nodes.simd.lanes import LANES, select, splat_doubles, to_doubles
from flowabs_nodes.simd.memory import gather_pairs, load, load_pairs, prefetch, scratch, store

BLOCKS = 8  # walks of sixteen pixels each
BATCH = BLOCKS * LANES


class Streamlines(NamedTuple):
    """Where the walks of 64 pixels of a row are, both ways.

    Walk k = 0, 2, 4, 6 goes along the tangents of sixteen pixels, k + 1 against them; at [16 k] is what is theirs.
    """

    pixel: Any  # the number of the one nearest to z
    dx: Any  # z - x, the offset from the centre
    dy: Any
    tx: Any  # t(z), the way the walk goes on
    ty: Any


@inline
def new_streamlines() -> Streamlines:
    return Streamlines(
        scratch(np.int32, BLOCKS),
        scratch(np.float64, BLOCKS),
        scratch(np.float64, BLOCKS),
        scratch(np.float32, BLOCKS),
        scratch(np.float32, BLOCKS),
    )


@inlined
def block_column(x0: int, at: int, raster: Raster) -> int:
    """The first of the sixteen columns whose walk is at [at]; where the row ends, the last ones are walked twice."""
    return min(x0 + at // (2 * LANES) * LANES, raster.stride - LANES)


@inlined
def start(curves: Streamlines, flow: Any, x0: int, y: int, raster: Raster) -> None:
    """From the centres x0 .. x0 + 63 of row y. ``flow`` is complex64: a pair of floats for each pixel."""
    for at in range(0, BATCH, 2 * LANES):
        tx, ty = load_pairs(flow, y * raster.stride + block_column(x0, at, raster))
        _set_out(curves, at, tx, ty)
        _set_out(curves, at + LANES, -tx, -ty)


@inlined
def prefetch_tangents(flow: Any, x: int, y: int, below: int, raster: Raster) -> None:
    """Have those fetched that walks will come to before long; ``below``: the first row that is not yet."""
    pixel = min(y + below, raster.height - 1) * raster.stride + x
    prefetch(flow, pixel)
    prefetch(flow, pixel + LANES // 2)


@inlined
def _set_out(curves: Streamlines, at: int, tx: Any, ty: Any) -> None:
    store(curves.dx, at, splat_doubles(0.0))
    store(curves.dy, at, splat_doubles(0.0))
    store(curves.tx, at, tx)
    store(curves.ty, at, ty)


@inlined
def advance(curves: Streamlines, at: int, x: int, y: int, raster: Raster) -> Any:
    """z + t(z) for the sixteen walks at [at]; returns column and row of the pixels nearest to it."""
    dx, dy = (
        load(curves.dx, at) + to_doubles(load(curves.tx, at)),
        load(curves.dy, at) + to_doubles(load(curves.ty, at)),
    )
    store(curves.dx, at, dx)
    store(curves.dy, at, dy)
    columns, rows = nearest_pixels(dx, dy, x, y, raster)
    store(curves.pixel, at, rows * raster.stride + columns)
    return columns, rows


@inlined
def turn(curves: Streamlines, flow: Any) -> None:
    """After a step of all the walks, before the next: the tangents at z, turned to go on the same way."""
    for at in range(0, BATCH, LANES):
        tx, ty = gather_pairs(flow, curves.pixel, at)
        against = tx * load(curves.tx, at) < -(ty * load(curves.ty, at))  # right also where a sum would round
        store(curves.tx, at, select(against, -tx, tx))
        store(curves.ty, at, select(against, -ty, ty))
