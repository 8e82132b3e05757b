"""Eq. 6 as it stands: a gradient line through every point of the curve, for tangents of any length.

With one weight it is eq. 10, with one tap eq. 11: this is also what is left where tangents are not about unit vectors,
on which :mod:`gradient_line` and :mod:`flow_blur` count.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.sampling.coords import Frame, between, frame_of
from flowabs_nodes.sampling.streamline import ALL, Walks, advance, column, new_walks, set_out, turn
from flowabs_nodes.sampling.tile_cache import widened
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inline, kernel
from flowabs_nodes.simd.lanes import LANES, inlined, lane_numbers, same_floats, to_doubles, to_floats
from flowabs_nodes.simd.memory import load, pairs_at, scratch, store

_SUMS = 16  # four planes of 64 pixels
_TOGETHER = 8  # points of a line, whose places are worked out before they are read


class Points(NamedTuple):
    """Where the walks of 64 pixels are, and some points of a gradient line there."""

    x: Any  # offsets from the centres
    y: Any
    place: Any  # the pixel at the upper left of each point
    u: Any  # how far beyond it the point is, 0..1
    v: Any


@inline
def _new_points() -> Points:
    return Points(
        scratch(np.float64, 8),
        scratch(np.float64, 8),
        scratch(np.int32, 8),
        scratch(np.float32, 8),
        scratch(np.float32, 8),
    )


def full(
    planes: Array, flow: Array, taps: npt.NDArray[np.float64], weights: npt.NDArray[np.float64], sampling: str
) -> Array:
    """The sum over curve and gradient lines for each of up to four planes (C, H, W).

    ``taps`` are the weights of the steps 0, 1 .. to either side of the curve, ``weights`` those of the steps along it.
    """
    _, height, width = planes.shape
    planes, flow = widened(planes, 2), widened(flow, 1)
    result = np.empty_like(planes)
    factors = taps.astype(np.float32), weights.astype(np.float32)
    tangents = flow.reshape(-1).view(np.complex64)
    over_rows(_full, height, planes, tangents, *factors, sampling == "nearest", frame_of(flow), result)
    return np.ascontiguousarray(result[..., :width])


@kernel
def _full(
    first: int, last: int, planes: Any, flow: Any, taps: Any, weights: Any, to_nearest: bool, frame: Frame, result: Any
) -> None:
    source, target, channels = planes.reshape(-1), result.reshape(-1), planes.shape[0]
    walks, points, total = new_walks(), _new_points(), scratch(np.float32, _SUMS)
    for row in range(first, last):
        for x0 in range(0, frame.width, ALL // 2):
            set_out(walks, flow, x0, row, frame)
            for k in range(0, 4 * ALL // 2, LANES):
                store(total, k, same_floats(0.0))
            for at in range(0, ALL, 2 * LANES):
                store(points.x, at, load(walks.dx, at))
                store(points.y, at, load(walks.dy, at))
                _add_line(total, source, channels, walks, points, at, x0, row, taps, weights[0], frame)
            for s in range(1, weights.size):
                for at in range(0, ALL, LANES):
                    first_column = column(x0, at, frame)
                    columns, rows = advance(walks, at, first_column, row, frame)
                    if to_nearest:  # the line goes through the pixel itself
                        store(points.x, at, to_doubles(to_floats(columns - (lane_numbers() + first_column))))
                        store(points.y, at, to_doubles(to_floats(rows - row)))
                    else:
                        store(points.x, at, load(walks.dx, at))
                        store(points.y, at, load(walks.dy, at))
                turn(walks, flow)
                for at in range(0, ALL, LANES):
                    _add_line(total, source, channels, walks, points, at, x0, row, taps, weights[s], frame)
            for c in range(channels):
                for at in range(0, ALL, 2 * LANES):
                    to = (c * frame.height + row) * frame.width + column(x0, at, frame)
                    store(target, to, load(total, c * ALL // 2 + at // 2))


@inlined
def _add_line(
    total: Any,
    source: Any,
    channels: int,
    walks: Walks,
    points: Points,
    at: int,
    x0: int,
    row: int,
    taps: Any,
    weight: Any,
    frame: Frame,
) -> None:
    """To ``total``, the gradient lines through the points of the walks at [at]."""
    size, below = frame.width * frame.height, frame.width if frame.height > 1 else 0
    tx, ty = to_doubles(load(walks.tx, at)), to_doubles(load(walks.ty, at))
    x, y = load(points.x, at), load(points.y, at)
    for n0 in range(1 - taps.size, taps.size, _TOGETHER):
        n_end = min(n0 + _TOGETHER, taps.size)
        for n in range(n0, n_end):
            corner = between(x + ty * n, y - tx * n, column(x0, at, frame), row, frame)
            store(points.place, LANES * (n - n0), corner.y * frame.width + corner.x)
            store(points.u, LANES * (n - n0), corner.fx)
            store(points.v, LANES * (n - n0), corner.fy)
        for c in range(channels):
            plane, to = source[c * size :], (c * ALL // 2 + at // 2) // LANES * LANES
            both = load(total, to)
            for n in range(n0, n_end):
                k = LANES * (n - n0)
                a, b = pairs_at(plane, points.place, k)
                d, e = pairs_at(plane[below:], points.place, k)
                upper, lower = a + load(points.u, k) * (b - a), d + load(points.u, k) * (e - d)
                both = both + (upper + load(points.v, k) * (lower - upper)) * (weight * taps[abs(n)])
            store(total, to, both)
