"""Streamlines in a tile: those of :mod:`~flowabs_nodes.sampling.streamline`, a row of the tile at a time.

Offsets are int32 in fixed point, so their sums are exact and round as exact arithmetic would. They are measured from a
*reference pixel* near z, not from the pixel x where the streamline starts, so they stay small. The reference pixel is
an even number of columns and rows away from x, so that offsets from both round, half to even, to the same pixel.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array, Int32
from flowabs_nodes.sampling.tile_cache import COLUMNS, Tile, tile_offset
from flowabs_nodes.simd.jit import inline, inlined
from flowabs_nodes.simd.lanes import LANES, Floats, Ints, Masks, lane_indices, select, splat_ints, to_floats, to_ints
from flowabs_nodes.simd.memory import load, scratch, store

#: How many blocks of sixteen pixels a row of a tile has.
BLOCKS = COLUMNS // LANES

_STREAMLINES = 2 * BLOCKS  # in blocks of sixteen: along the tangents of a block of pixels, against them, the next block
_POINT = 28  # binary places behind the point; before it are the sign and three places
_ONE = 1 << _POINT
_STEPS = 4  # from one reference pixel to the next: offsets up to 2 + 4 LONGEST fit into three places, below 8


class TiledStreamlines(NamedTuple):
    """The state of the streamlines of a row of a tile, in scratch memory.

    Blocks of sixteen go along the tangents of sixteen pixels and against them, by turns. ``k`` in the functions below
    is the index at which the state of a block begins, a multiple of sixteen.
    """

    x: Int32  # column and row of the reference pixel
    y: Int32
    dx: Int32  # the offset of z from it, in units of 2^-28 pixels
    dy: Int32
    tx: Array  # t(z), with the sign that continues the streamline
    ty: Array
    corner: Int32  # index in the tile of the upper left of the four pixels around z
    nearest: Int32  # index in the tile of the record of the pixel nearest to z


@inline
def new_tiled_streamlines() -> TiledStreamlines:
    """Return the uninitialised state of the streamlines of a row of a tile on the kernel's stack."""
    return TiledStreamlines(
        scratch(np.int32, _STREAMLINES),
        scratch(np.int32, _STREAMLINES),
        scratch(np.int32, _STREAMLINES),
        scratch(np.int32, _STREAMLINES),
        scratch(np.float32, _STREAMLINES),
        scratch(np.float32, _STREAMLINES),
        scratch(np.int32, _STREAMLINES),
        scratch(np.int32, _STREAMLINES),
    )


@inlined
def start(curves: TiledStreamlines, k: int, x: int, y: int, tx: Floats, ty: Floats) -> None:
    """Start the block at ``k`` at the centres of the pixels x .. x + 15 of row y, along the tangents (tx, ty)."""
    store(curves.x, k, lane_indices() + x)
    store(curves.y, k, splat_ints(y))
    store(curves.dx, k, splat_ints(0))
    store(curves.dy, k, splat_ints(0))
    store(curves.tx, k, tx)
    store(curves.ty, k, ty)


@inlined
def advance(curves: TiledStreamlines, k: int, s: int, tile: Tile, size: int) -> None:
    """Take the s-th step, s = 1, 2 .., of the block at ``k``: z <- z + t(z).

    ``size`` is the length in pairs of floats of the records read at the nearest pixel: 1 for tangents alone, or 2.
    """
    x, dx = _moved(curves.x, curves.dx, curves.tx, k, s)
    y, dy = _moved(curves.y, curves.dy, curves.ty, k, s)
    columns, rows = dx >> _POINT, dy >> _POINT
    corner = tile_offset(x + columns, y + rows, tile)
    store(curves.corner, k, corner)
    nearest = select(_past_half(dx, columns), corner + 1, corner)
    nearest = select(_past_half(dy, rows), nearest + tile.stride, nearest)
    store(curves.nearest, k, nearest * size)


@inlined
def turn(curves: TiledStreamlines, k: int, tx: Floats, ty: Floats) -> None:
    """Set t(z) of the block at ``k`` to (tx, ty), negated where it points against the last step."""
    # Whether the dot product is negative, told without a sum that could round to 0.
    against = tx * load(curves.tx, k) < -(ty * load(curves.ty, k))
    store(curves.tx, k, select(against, -tx, tx))
    store(curves.ty, k, select(against, -ty, ty))


@inlined
def fraction_beyond(d: Ints) -> Floats:
    """Return the fraction of the fixed-point offset ``d``, 0 to 1 pixel: the distance of z from its corner."""
    return to_floats(d & (_ONE - 1)) * (1.0 / _ONE)


@inlined
def _moved(pixels: Int32, offsets: Int32, tangents: Array, k: int, s: int) -> tuple[Ints, Ints]:
    """Take the s-th step in one coordinate, and return the reference pixel's and the offset from it.

    The arguments are the fields x, dx and tx of :class:`TiledStreamlines`, or y, dy and ty.
    """
    pixel, d = load(pixels, k), load(offsets, k)
    if s % _STEPS == 0:
        whole = (d >> _POINT) & -2
        pixel, d = pixel + whole, d - (whole << _POINT)
        store(pixels, k, pixel)
    d = d + to_ints(load(tangents, k) * float(_ONE))
    store(offsets, k, d)
    return pixel, d


@inlined
def _past_half(d: Ints, whole: Ints) -> Masks:
    """Return whether ``d`` (fixed point) rounds to whole + 1, half to even, rather than to ``whole``, its floor."""
    return (d & (_ONE - 1)) + (whole & 1) > _ONE // 2
