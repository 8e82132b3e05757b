"""Eq. 6 of the paper as it stands: a sum over the gradient line through every point of the flow axis.

The FDoG filter uses it with ``kernel="full"``. With the single weight 1 along the flow axis, eq. 6 is eq. 10, and with
the single weight 1 on the gradient lines it is eq. 11. The fast kernels of eqs. 10 and 11 work in tiles, for which no
tangent may be much longer than 1 (:mod:`~flowabs_nodes.sampling.tile_cache`); for all other flows this kernel computes
them too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array, Complex64, Float64, Int32
from flowabs_nodes.sampling.coords import Raster, bilinear_coords, raster_of
from flowabs_nodes.sampling.streamline import BATCH, Streamlines, advance, block_column, new_streamlines, start, turn
from flowabs_nodes.sampling.tile_cache import pad_width
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inline, inlined, kernel
from flowabs_nodes.simd.lanes import LANES, lane_indices, splat_floats, to_doubles, to_floats
from flowabs_nodes.simd.memory import gather_pairs, load, scratch, store

_PIXELS = BATCH // 2  # whose streamlines are followed at a time
_MOST_PLANES = 4
_TOGETHER = 8  # points of a gradient line whose coordinates are computed before the first is read


class Weights(NamedTuple):
    """The weights of eq. 6 at the steps 0, 1 .. to either side, float32."""

    across: Array  # f(t), on the gradient lines
    along: Array  # G_sigma_m(s), on the flow axis


class Block(NamedTuple):
    """Sixteen streamlines: those of the pixels x .. x + 15 of row y, in one direction."""

    at: int  # index in scratch memory at which their state begins
    x: int
    y: int


class LineScratch(NamedTuple):
    """The sums of 64 pixels, and the points at work of their gradient lines, in scratch memory."""

    total: Array  # the sums, of each plane in turn
    x: Float64  # the offset of c_x(s) from the pixel x, for each of the 128 streamlines
    y: Float64
    place: Int32  # index in a plane of the upper left of the four pixels around l_x,s(t)
    u: Array  # distance of l_x,s(t) from it, to the right and down, 0 to 1
    v: Array


@inline
def _new_line_scratch() -> LineScratch:
    """Return uninitialised memory on the kernel's stack."""
    return LineScratch(
        scratch(np.float32, 16),
        scratch(np.float64, 8),
        scratch(np.float64, 8),
        scratch(np.int32, 8),
        scratch(np.float32, 8),
        scratch(np.float32, 8),
    )


def exact_sum(planes: Array, flow: Array, taps: Float64, weights: Float64, sampling: str) -> Array:
    """Return eq. 6 for each of up to four planes: the weighted sum over the flow axis and its gradient lines.

    Parameters
    ----------
    planes
        (C, H, W), any scale.
    flow
        (H, W, 2), tangents of any length, x right and y down.
    taps
        f(t) at t = 0, 1 .., the weights of the steps to either side on the gradient lines. Planes are read bilinearly.
    weights
        G_sigma_m(s) at s = 0, 1 .., the weights of the steps to either side on the flow axis.
    sampling
        "bilinear": a gradient line goes through the point c_x(s). "nearest": through the nearest pixel.

    Returns
    -------
    (C, H, W).
    """
    _, height, width = planes.shape
    planes, flow = pad_width(planes, 2), pad_width(flow, 1)
    result = np.empty_like(planes)
    factors = Weights(taps.astype(np.float32), weights.astype(np.float32))
    tangents = flow.reshape(-1).view(np.complex64)
    over_rows(_sum_lines, height, planes, tangents, factors, sampling == "nearest", raster_of(flow), result)
    return np.ascontiguousarray(result[..., :width])


@kernel
def _sum_lines(
    first: int,
    last: int,
    planes: Array,
    flow: Complex64,
    weights: Weights,
    to_nearest: bool,
    raster: Raster,
    result: Array,
) -> None:
    """Write the rows first .. last - 1 of ``result``, (C, H, W) as ``planes``; ``flow`` is (H, W), flattened."""
    across, along = weights
    source, target, channels = planes.reshape(-1), result.reshape(-1), planes.shape[0]
    curves, lines = new_streamlines(), _new_line_scratch()
    for y in range(first, last):
        for x0 in range(0, raster.width, _PIXELS):
            start(curves, flow, x0, y, raster)
            for k in range(0, _MOST_PLANES * _PIXELS, LANES):
                store(lines.total, k, splat_floats(0.0))
            for at in range(0, BATCH, 2 * LANES):  # s = 0, one of the two directions
                store(lines.x, at, load(curves.dx, at))
                store(lines.y, at, load(curves.dy, at))
                block = Block(at, block_column(x0, at, raster), y)
                _add_line(source, channels, curves, lines, block, across, along[0], raster)
            for s in range(1, along.size):
                for at in range(0, BATCH, LANES):
                    x = block_column(x0, at, raster)
                    columns, rows = advance(curves, at, x, y, raster)
                    if to_nearest:
                        store(lines.x, at, to_doubles(to_floats(columns - (lane_indices() + x))))
                        store(lines.y, at, to_doubles(to_floats(rows - y)))
                    else:
                        store(lines.x, at, load(curves.dx, at))
                        store(lines.y, at, load(curves.dy, at))
                turn(curves, flow)
                for at in range(0, BATCH, LANES):
                    block = Block(at, block_column(x0, at, raster), y)
                    _add_line(source, channels, curves, lines, block, across, along[s], raster)
            for c in range(channels):
                for at in range(0, BATCH, 2 * LANES):
                    to = (c * raster.height + y) * raster.width + block_column(x0, at, raster)
                    store(target, to, load(lines.total, c * _PIXELS + at // 2))


@inlined
def _add_line(
    source: Array,
    channels: int,
    curves: Streamlines,
    lines: LineScratch,
    block: Block,
    across: Array,
    weight: float,
    raster: Raster,
) -> None:
    """Add the gradient lines through c_x(s) of a block of streamlines to the sums of its pixels.

    ``source`` holds ``channels`` planes, flattened; ``across`` is f(t) and ``weight`` G_sigma_m(s).
    """
    at = block.at
    size, below = raster.width * raster.height, raster.width if raster.height > 1 else 0
    tx, ty = to_doubles(load(curves.tx, at)), to_doubles(load(curves.ty, at))
    x, y = load(lines.x, at), load(lines.y, at)
    for t0 in range(1 - across.size, across.size, _TOGETHER):
        t_end = min(t0 + _TOGETHER, across.size)
        for t in range(t0, t_end):
            corner = bilinear_coords(x + ty * t, y - tx * t, block.x, block.y, raster)
            store(lines.place, LANES * (t - t0), corner.y * raster.width + corner.x)
            store(lines.u, LANES * (t - t0), corner.fx)
            store(lines.v, LANES * (t - t0), corner.fy)
        for c in range(channels):
            plane, to = source[c * size :], (c * _PIXELS + at // 2) // LANES * LANES
            total = load(lines.total, to)
            for t in range(t0, t_end):
                k = LANES * (t - t0)
                a, b = gather_pairs(plane, lines.place, k)
                d, e = gather_pairs(plane[below:], lines.place, k)
                upper, lower = a + load(lines.u, k) * (b - a), d + load(lines.u, k) * (e - d)
                value = upper + load(lines.v, k) * (lower - upper)
                total = total + value * (weight * across[abs(t)])  # eq. 6
            store(lines.total, to, total)
