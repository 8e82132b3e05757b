"""Following the flow (section 3.3) in a tile: the Euler steps of :mod:`~flowabs_nodes.filters.walk`, many at a time.

Offsets are in fixed point: sums are exact, and what rounding decides is what exact arithmetic would decide. They are
those from a pixel near z, an even number of columns and rows from the centre, so that they never grow and still round
half to even as the offset from the centre would.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from flowabs_nodes.sampling.tile_cache import COLUMNS, Tile, place
from flowabs_nodes.simd.jit import inline
from flowabs_nodes.simd.lanes import LANES, inlined, lane_numbers, same_ints, select, to_floats, to_ints
from flowabs_nodes.simd.memory import load, scratch, store

BLOCKS = COLUMNS // LANES
WALKS = 2 * BLOCKS  # sixteen pixels along their tangents, the same against them, then the next sixteen pixels

_POINT = 28  # binary places behind the point; before it there are a sign and three more
_ONE = 1 << _POINT
_STEPS = 4  # from one pixel to be measured from to the next: offsets of up to 2 + 4 * 1.25 are less than 8


class Walks(NamedTuple):
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
def new_walks() -> Walks:
    return Walks(
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
def set_out(walks: Walks, k: int, x: int, y: int, tx: Any, ty: Any) -> None:
    """From the centres x .. x + 15 of row y, along these tangents."""
    store(walks.x, k, lane_numbers() + x)
    store(walks.y, k, same_ints(y))
    store(walks.dx, k, same_ints(0))
    store(walks.dy, k, same_ints(0))
    store(walks.tx, k, tx)
    store(walks.ty, k, ty)


@inlined
def advance(walks: Walks, k: int, s: int, tile: Tile, size: int) -> None:
    """The s-th step, z + t(z). ``size``, 1 or 2: of what there is to read at the nearest pixel, in pairs of floats."""
    x, dx = _moved(walks.x, walks.dx, walks.tx, k, s)
    y, dy = _moved(walks.y, walks.dy, walks.ty, k, s)
    columns, rows = dx >> _POINT, dy >> _POINT
    corner = place(x + columns, y + rows, tile)
    store(walks.corner, k, corner)
    nearest = select(_past_half(dx, columns), corner + 1, corner)
    nearest = select(_past_half(dy, rows), nearest + tile.stride, nearest)
    store(walks.nearest, k, nearest * size)


@inlined
def turn(walks: Walks, k: int, tx: Any, ty: Any) -> None:
    """t(z) is this tangent, turned round when it disagrees with the last step."""
    against = tx * load(walks.tx, k) < -(ty * load(walks.ty, k))  # right also where float32 sums would round
    store(walks.tx, k, select(against, -tx, tx))
    store(walks.ty, k, select(against, -ty, ty))


@inlined
def beyond(d: Any) -> Any:
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
