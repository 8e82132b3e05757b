"""Following the flow (section 3.3) in a tile: the Euler steps of :mod:`~flowabs_nodes.filters.walk`, many at a time.

Offsets are in fixed point: sums are exact, and what rounding decides is what exact arithmetic would decide. They are
those from a pixel near z, an even number of columns and rows from the centre, so that they never grow and still round
half to even as the offset from the centre would.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from flowabs_nodes.sampling.tile_cache import COLUMNS, Tile, tile_offset
from flowabs_nodes.simd.jit import inline, inlined
from flowabs_nodes.simd.lanes import LANES, lane_indices, select, splat_ints, to_floats, to_ints
from flowabs_nodes.simd.memory import load, scratch, store

BLOCKS = COLUMNS // LANES
WALKS = 2 * BLOCKS  # sixteen pixels along their tangents, the same against them, then the next sixteen pixels

_POINT = 28  # binary places behind the point; before it there are a sign and three more
_ONE = 1 << _POINT
_STEPS = 4  # from one pixel to be measured from to the next: offsets of up to 2 + 4 * 1.25 are less than 8


class TiledStreamlines(NamedTuple):
    """Where the walks of a row of a tile are, in scratch memory of WALKS vectors each."""

    x: Any  # the pixel that offsets are measured from
    y: Any
    dx: Any  # the offset of z from it
    dy: Any
    tx: Any  # t(z), the way the walk goes on
    ty: Any
    corner: Any  # where in the tile the pixel is that has z at its lower right
    nearest: Any  # where in the tile what is to be read of the pixel nearest to z is


@inline
def new_tiled_streamlines() -> TiledStreamlines:
    return TiledStreamlines(
        scratch(np.int32, WALKS),
        scratch(np.int32, WALKS),
        scratch(np.int32, WALKS),
        scratch(np.int32, WALKS),
        scratch(np.float32, WALKS),
        scratch(np.float32, WALKS),
        scratch(np.int32, WALKS),
        scratch(np.int32, WALKS),
    )


@inlined
def start(curves: TiledStreamlines, k: int, x: int, y: int, tx: Any, ty: Any) -> None:
    """From the centres x .. x + 15 of row y, along these tangents."""
    store(curves.x, k, lane_indices() + x)
    store(curves.y, k, splat_ints(y))
    store(curves.dx, k, splat_ints(0))
    store(curves.dy, k, splat_ints(0))
    store(curves.tx, k, tx)
    store(curves.ty, k, ty)


@inlined
def advance(curves: TiledStreamlines, k: int, s: int, tile: Tile, size: int) -> None:
    """The s-th step, z + t(z). ``size``, 1 or 2: of what there is to read at the nearest pixel, in pairs of floats."""
    x, dx = _moved(curves.x, curves.dx, curves.tx, k, s)
    y, dy = _moved(curves.y, curves.dy, curves.ty, k, s)
    columns, rows = dx >> _POINT, dy >> _POINT
    corner = tile_offset(x + columns, y + rows, tile)
    store(curves.corner, k, corner)
    nearest = select(_past_half(dx, columns), corner + 1, corner)
    nearest = select(_past_half(dy, rows), nearest + tile.stride, nearest)
    store(curves.nearest, k, nearest * size)


@inlined
def turn(curves: TiledStreamlines, k: int, tx: Any, ty: Any) -> None:
    """t(z) is this tangent, turned round when it disagrees with the last step."""
    against = tx * load(curves.tx, k) < -(ty * load(curves.ty, k))  # right also where float32 sums would round
    store(curves.tx, k, select(against, -tx, tx))
    store(curves.ty, k, select(against, -ty, ty))


@inlined
def fraction_beyond(d: Any) -> Any:
    """How far z is from its corner in this direction, 0..1."""
    return to_floats(d & (_ONE - 1)) * (1.0 / _ONE)


@inlined
def _moved(pixels: Any, offsets: Any, tangents: Any, k: int, s: int) -> tuple[Any, Any]:
    """The pixel and the offset from it one step further."""
    pixel, d = load(pixels, k), load(offsets, k)
    if s % _STEPS == 0:
        whole = (d >> _POINT) & -2
        pixel, d = pixel + whole, d - (whole << _POINT)
        store(pixels, k, pixel)
    d = d + to_ints(load(tangents, k) * float(_ONE))
    store(offsets, k, d)
    return pixel, d


@inlined
def _past_half(d: Any, whole: Any) -> Any:
    """Whether the next whole number is nearer, or as near and even."""
    return (d & (_ONE - 1)) + (whole & 1) > _ONE // 2
