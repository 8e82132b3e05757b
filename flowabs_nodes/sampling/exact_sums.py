"""Eq. 6 as it stands: a gradient line through every point of the curve, for tangents of any length.

With one weight it is eq. 10, with one tap eq. 11: this is also what is left where tangents are not about unit vectors,
on which :mod:`gradient_line` and :mod:`flow_blur` count.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.sampling.coords import Raster, bilinear_coords, raster_of
from flowabs_nodes.sampling.streamline import BATCH, Streamlines, advance, block_column, new_streamlines, start, turn
from flowabs_nodes.sampling.tile_cache import pad_width
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inline, inlined, kernel
from flowabs_nodes.simd.lanes import LANES, lane_indices, splat_floats, to_doubles, to_floats
from flowabs_nodes.simd.memory import gather_pairs, load, scratch, store

_SUMS = 16  # four planes of 64 pixels
_TOGETHER = 8  # points of a line, whose places are worked out before they are read


class LinePoints(NamedTuple):
    """Where the walks of 64 pixels are, and some points of a gradient line there."""

    x: Any  # offsets from the centres
    y: Any
    place: Any  # the pixel at the upper left of each point
    u: Any  # how far beyond it the point is, 0..1
    v: Any


@inline
def _new_points() -> LinePoints:
    return LinePoints(
        scratch(np.float64, 8),
        scratch(np.float64, 8),
        scratch(np.int32, 8),
        scratch(np.float32, 8),
        scratch(np.float32, 8),
    )


def exact_sum(
    planes: Array, flow: Array, taps: npt.NDArray[np.float64], weights: npt.NDArray[np.float64], sampling: str
) -> Array:
    """The sum over curve and gradient lines for each of up to four planes (C, H, W).

    ``taps`` are the weights of the steps 0, 1 .. to either side of the curve, ``weights`` those of the steps along it.
    """
    _, height, width = planes.shape
    planes, flow = pad_width(planes, 2), pad_width(flow, 1)
    result = np.empty_like(planes)
    factors = taps.astype(np.float32), weights.astype(np.float32)
    tangents = flow.reshape(-1).view(np.complex64)
    over_rows(_full, height, planes, tangents, *factors, sampling == "nearest", raster_of(flow), result)
    return np.ascontiguousarray(result[..., :width])


@kernel
def _full(
    first: int,
    last: int,
    planes: Any,
    flow: Any,
    taps: Any,
    weights: Any,
    to_nearest: bool,
    raster: Raster,
    result: Any,
) -> None:
    source, target, channels = planes.reshape(-1), result.reshape(-1), planes.shape[0]
    curves, points, total = new_streamlines(), _new_points(), scratch(np.float32, _SUMS)
    for row in range(first, last):
        for x0 in range(0, raster.width, BATCH // 2):
            start(curves, flow, x0, row, raster)
            for k in range(0, 4 * BATCH // 2, LANES):
                store(total, k, splat_floats(0.0))
            for at in range(0, BATCH, 2 * LANES):
                store(points.x, at, load(curves.dx, at))
                store(points.y, at, load(curves.dy, at))
                _add_line(total, source, channels, curves, points, at, x0, row, taps, weights[0], raster)
            for s in range(1, weights.size):
                for at in range(0, BATCH, LANES):
                    first_column = block_column(x0, at, raster)
                    columns, rows = advance(curves, at, first_column, row, raster)
                    if to_nearest:  # the line goes through the pixel itself
                        store(points.x, at, to_doubles(to_floats(columns - (lane_indices() + first_column))))
                        store(points.y, at, to_doubles(to_floats(rows - row)))
                    else:
                        store(points.x, at, load(curves.dx, at))
                        store(points.y, at, load(curves.dy, at))
                turn(curves, flow)
                for at in range(0, BATCH, LANES):
                    _add_line(total, source, channels, curves, points, at, x0, row, taps, weights[s], raster)
            for c in range(channels):
                for at in range(0, BATCH, 2 * LANES):
                    to = (c * raster.height + row) * raster.width + block_column(x0, at, raster)
                    store(target, to, load(total, c * BATCH // 2 + at // 2))


@inlined
def _add_line(
    total: Any,
    source: Any,
    channels: int,
    curves: Streamlines,
    points: LinePoints,
    at: int,
    x0: int,
    row: int,
    taps: Any,
    weight: Any,
    raster: Raster,
) -> None:
    """To ``total``, the gradient lines through the points of the walks at [at]."""
    size, below = raster.width * raster.height, raster.width if raster.height > 1 else 0
    tx, ty = to_doubles(load(curves.tx, at)), to_doubles(load(curves.ty, at))
    x, y = load(points.x, at), load(points.y, at)
    for n0 in range(1 - taps.size, taps.size, _TOGETHER):
        n_end = min(n0 + _TOGETHER, taps.size)
        for n in range(n0, n_end):
            corner = bilinear_coords(x + ty * n, y - tx * n, block_column(x0, at, raster), row, raster)
            store(points.place, LANES * (n - n0), corner.y * raster.width + corner.x)
            store(points.u, LANES * (n - n0), corner.fx)
            store(points.v, LANES * (n - n0), corner.fy)
        for c in range(channels):
            plane, to = source[c * size :], (c * BATCH // 2 + at // 2) // LANES * LANES
            both = load(total, to)
            for n in range(n0, n_end):
                k = LANES * (n - n0)
                a, b = gather_pairs(plane, points.place, k)
                d, e = gather_pairs(plane[below:], points.place, k)
                upper, lower = a + load(points.u, k) * (b - a), d + load(points.u, k) * (e - d)
                both = both + (upper + load(points.v, k) * (lower - upper)) * (weight * taps[abs(n)])
            store(total, to, both)
