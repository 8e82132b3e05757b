"""Streamlines of the flow: the flow axis c_x of each pixel x, sampled as in section 3.3 of the paper.

From z = x, Euler steps of one pixel, z <- z + t(z), lead along the tangent of x, and others against it. t(z) is read at
the pixel nearest to z. The flow has no sign, so t(z) is negated where it points against the last step. Where t(z) is
zero, z stays. Streamlines go on past the border, along the tangents of the border pixels.

Offsets z - x are summed in float64: they round to the same pixels as with exact arithmetic on the float32 tangents.

Each step waits for its tangent to be read. A kernel therefore follows many streamlines at a time, whose state is in
scratch memory: all of them advance, then all read their next tangents.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array, Complex64, Float64, Int32
from flowabs_nodes.sampling.coords import Raster, nearest_pixels
from flowabs_nodes.simd.jit import inline, inlined
from flowabs_nodes.simd.lanes import LANES, Floats, Ints, select, splat_doubles, to_doubles
from flowabs_nodes.simd.memory import gather_pairs, load, load_pairs, prefetch, scratch, store

#: How many blocks of sixteen streamlines are followed at a time: four of pixels, along and against the flow.
BLOCKS = 8
#: How many streamlines are followed at a time, those of 64 pixels.
BATCH = BLOCKS * LANES


class Streamlines(NamedTuple):
    """The state of the streamlines of 64 pixels of a row, in scratch memory.

    Blocks k = 0, 2, 4, 6 go along the tangents of sixteen pixels each, block k + 1 against those of the same pixels.
    The state of block k begins at index 16 k of each field; ``at`` in the functions below is such an index.
    """

    pixel: Int32  # row x stride + column of the pixel nearest to z
    dx: Float64  # z - x, in pixels
    dy: Float64
    tx: Array  # t(z), with the sign that continues the streamline
    ty: Array


@inline
def new_streamlines() -> Streamlines:
    """Return the uninitialised state of 64 pixels' streamlines on the kernel's stack."""
    return Streamlines(
        scratch(np.int32, BLOCKS),
        scratch(np.float64, BLOCKS),
        scratch(np.float64, BLOCKS),
        scratch(np.float32, BLOCKS),
        scratch(np.float32, BLOCKS),
    )


@inlined
def block_column(x0: int, at: int, raster: Raster) -> int:
    """Return the first of the sixteen columns whose streamlines are at ``at``, for 64 pixels from column x0 on.

    At the end of a row the block moves to the left until it fits, and overlaps the one before it.
    """
    return min(x0 + at // (2 * LANES) * LANES, raster.stride - LANES)


@inlined
def start(curves: Streamlines, flow: Complex64, x0: int, y: int, raster: Raster) -> None:
    """Start the streamlines of the pixels x0 .. x0 + 63 of row y at their centres.

    ``flow`` is (H, stride) complex64, flattened: t.x + i t.y for each pixel.
    """
    for at in range(0, BATCH, 2 * LANES):
        tx, ty = load_pairs(flow, y * raster.stride + block_column(x0, at, raster))
        _start_block(curves, at, tx, ty)
        _start_block(curves, at + LANES, -tx, -ty)


@inlined
def prefetch_tangents(flow: Complex64, x: int, y: int, below: int, raster: Raster) -> None:
    """Ask for the tangents ``below`` rows below the pixels x .. x + 15 of row y: the first row not yet in the cache."""
    pixel = min(y + below, raster.height - 1) * raster.stride + x
    prefetch(flow, pixel)
    prefetch(flow, pixel + LANES // 2)


@inlined
def _start_block(curves: Streamlines, at: int, tx: Floats, ty: Floats) -> None:
    """Start the sixteen streamlines at ``at`` with the tangents (tx, ty)."""
    store(curves.dx, at, splat_doubles(0.0))
    store(curves.dy, at, splat_doubles(0.0))
    store(curves.tx, at, tx)
    store(curves.ty, at, ty)


@inlined
def advance(curves: Streamlines, at: int, x: int, y: int, raster: Raster) -> tuple[Ints, Ints]:
    """Take a step, z <- z + t(z), of the sixteen streamlines at ``at``, which started from x .. x + 15 of row y.

    Returns column and row of the pixels nearest to z.
    """
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
def turn(curves: Streamlines, flow: Complex64) -> None:
    """Read t(z) for all streamlines, and negate it where it points against the last step."""
    for at in range(0, BATCH, LANES):
        tx, ty = gather_pairs(flow, curves.pixel, at)
        # Whether the dot product is negative, told without a sum that could round to 0.
        against = tx * load(curves.tx, at) < -(ty * load(curves.ty, at))
        store(curves.tx, at, select(against, -tx, tx))
        store(curves.ty, at, select(against, -ty, ty))
