"""Ink and distances: each pixel's nearest edges, by the pieces of lines through their points.

A piece at p with normal n (outward) reaches over the pixels q whose (q - p).t is at most 3/4 px, more further away;
there d = (p - q).n, positive on the near side. Of several pieces the nearest point counts, the weaker the further away;
so distances belong to one edge, and ink to the nearest edge whose near side a pixel is on as well as to the nearest
whose far side it is on. A line lies on the near side, a crease on both:

    ink = strength clip(min(d, width - d) + 1/2, 0, 1),    of a crease: strength clip(width / 2 - |d| + 1/2, 0, 1).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array, Float64, Int32
from flowabs_nodes.filters.passes.edges import CREASE, FARTHEST, KINDS, Edges
from flowabs_nodes.filters.passes.near import MOVED
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, absolute, any_lane, lane_indices, select, splat_ints, to_doubles, to_floats
from flowabs_nodes.simd.memory import address, keep, load, store

#: Distances are told up to this, in pixels; it stands where no edge is nearer.
FAR = 10.0

_WEAKER = 2.0  # px: how much further away a point without strength counts
_HALF, _SPREAD = 0.75, 0.7  # half the length of a piece, in pixels, and how much more for each pixel away
_BOTH = 0.5  # px^2: edges that are as near as that are both drawn
_TILE = 64  # pixels of a row
_BAND, _FADED = 2.0, 3.0  # px: strength is told this near an edge, and no more from there on


class Pens(NamedTuple):
    """Widths in pixels."""

    width: float
    crease_width: float


class Drawing(NamedTuple):
    """What is drawn, (H, W) float32 each; of size 0 where it is not asked for."""

    kinds: Array  # (5, H, W): ink of each kind
    lines: Array  # 1 paper, 0 ink
    strength: Array
    distance: Array


def draw(edges: Edges, creases: Edges, pens: Pens, height: int, width: int, *, apart: bool, measured: bool) -> Drawing:
    """Draw edges and creases; ``apart`` each kind for itself too, ``measured`` with strengths and distances."""
    reach, crease_reach = (FAR, FAR) if measured else (ink_reach(pens.width), ink_reach(pens.crease_width / 2))
    size = (height, width) if measured else (0, 0)
    drawing = Drawing(
        np.zeros((KINDS, height, width) if apart else (KINDS, 0, 0), np.float32),
        np.empty((height, width), np.float32),
        np.empty(size, np.float32),
        np.empty(size, np.float32),
    )
    over_rows(_draw, height, edges, creases, pens, reach, crease_reach, drawing)
    return drawing


def ink_reach(most: float) -> float:
    """Return how far away a point can be that puts ink up to ``most`` pixels from its line.

    Whatever lies further away is the nearest of no pixel with ink, so that looking no further changes no line.
    """
    d = most + 0.5
    return min(math.sqrt(d * d + (_HALF + _SPREAD * d) ** 2 + _WEAKER * _WEAKER), FAR)


@kernel
def _draw(
    first: int,
    last: int,
    edges: Edges,
    creases: Edges,
    pens: Pens,
    reach: float,
    crease_reach: float,
    drawing: Drawing,
) -> None:
    """Draw the rows ``first`` .. ``last`` - 1."""
    width = drawing.lines.shape[1]
    apart, measured = drawing.kinds.size > 0, drawing.distance.size > 0
    drawing.lines[first:last] = 1
    if measured:
        drawing.strength[first:last], drawing.distance[first:last] = 0, FAR
    # The nearest edge whose near side a pixel is on, and the one whose far side; and the nearest crease. Most of a
    # picture is near nothing: memory is only looked at in tiles that are near something. Rows are longer by a vector.
    shape, tiles = (last - first, width + LANES), (last - first, width // _TILE + 1)
    near, folded = np.zeros(tiles, np.bool_), np.zeros(tiles, np.bool_)
    squares, which = np.empty((2, *shape)), np.empty((2, *shape), np.int32)
    _nearest(first, last, edges, width, reach, False, near, squares, which)
    crease_squares, crease = np.empty((1, *shape)), np.empty((1, *shape), np.int32)
    _nearest(first, last, creases, width, crease_reach, True, folded, crease_squares, crease)
    for y in range(first, last):
        j = y - first
        for tile in range(tiles[1]):
            if not (near[j, tile] or folded[j, tile]):
                continue
            for x in range(tile * _TILE, min((tile + 1) * _TILE, width)):
                inner = outer = fold = np.inf
                if near[j, tile]:
                    inner, outer = squares[0, j, x], squares[1, j, x]
                if folded[j, tile]:
                    fold = crease_squares[0, j, x]
                if min(inner, outer, fold) == np.inf:
                    continue
                most, nearest, strength = 0.0, FAR, 0.0
                for side in range(2):
                    # Where lines meet, a pixel beyond the one's edge is on the other.
                    own, other = (inner, outer) if side == 0 else (outer, inner)
                    if own < np.inf and own <= other + _BOTH:
                        e = which[side, j, x]
                        d = _across(edges, e, x, y)
                        ink = edges.strength[e] * min(max(min(d, pens.width - d) + 0.5, 0.0), 1.0)
                        if apart:
                            drawing.kinds[edges.kind[e], y, x] = max(ink, drawing.kinds[edges.kind[e], y, x])
                        most = max(most, ink)
                        if own < other or side == 0:
                            nearest, strength = d, edges.strength[e]
                if fold < np.inf:
                    e = crease[0, j, x]
                    d, s = abs(_across(creases, e, x, y)), creases.strength[e]
                    ink = s * min(max(pens.crease_width / 2 - d + 0.5, 0.0), 1.0)
                    if apart:
                        drawing.kinds[CREASE, y, x] = ink
                    most = max(most, ink)
                    if fold < min(inner, outer):
                        nearest, strength = d, s
                drawing.lines[y, x] = 1 - most
                if measured:
                    drawing.distance[y, x] = min(max(nearest, -FAR), FAR)
                    drawing.strength[y, x] = strength * min(max((_FADED - abs(nearest)) / (_FADED - _BAND), 0.0), 1.0)


@inlined
def _across(edges: Edges, e: int, x: int, y: int) -> float:
    """Return d of a pixel, by a point of an edge."""
    d: float = (edges.x[e] - x) * edges.nx[e] + (edges.y[e] - y) * edges.ny[e]
    return d


@inlined
def _span(slope: float, most: float) -> tuple[float, float]:
    """Return 1 / ``slope``, and by how much t may change where slope t is to change by ``most``; 0, 1e6 if by any."""
    return (1 / slope, most / abs(slope) + 1e-9) if abs(slope) > 1e-6 else (0.0, 1e6)


@inlined
def _nearest(
    first: int,
    last: int,
    edges: Edges,
    width: int,
    reach: float,
    two_sided: bool,
    near: npt.NDArray[np.bool_],
    squares: Float64,
    which: Int32,
) -> None:
    """Write the index of the nearest point, within ``reach``, of each pixel of the rows first .. last - 1.

    In layer 0 of the results is the nearest one with d >= 0, or of all if ``two_sided``; in layer 1 that with d < 0.
    They are written in tiles that are ``near`` something alone; where in these nothing is, squares are infinite.
    """
    height = edges.rows.size - 1
    sides, rows, length = squares.shape
    square_at, which_at = address(squares.ravel(), 0), address(which.ravel(), 0)
    most = _HALF + _SPREAD * reach
    margin = math.ceil(math.hypot(reach, most) + MOVED + FARTHEST) + 1
    lanes = to_doubles(to_floats(lane_indices()))
    for e in range(edges.rows[max(first - margin, 0)], edges.rows[min(last + margin, height)]):
        strength = edges.strength[e]
        if strength <= 0:
            continue
        px, py, nx, ny = edges.x[e], edges.y[e], edges.nx[e], edges.ny[e]
        weaker = (_WEAKER * (1 - strength)) ** 2
        tall = abs(ny) * reach + abs(nx) * most
        (per_d, wide), (per_s, long) = _span(nx, reach), _span(ny, most)
        for y in range(max(first, math.ceil(py - tall)), min(last, math.floor(py + tall) + 1)):
            dy = py - y
            # |dx nx + dy ny| <= reach and |dy nx - dx ny| <= most hold for dx from low to high, and for little else.
            low = max(-dy * ny * per_d - wide, dy * nx * per_s - long)
            high = min(-dy * ny * per_d + wide, dy * nx * per_s + long)
            begin, end = max(0, math.ceil(px - high)), min(width, math.floor(px - low) + 1)
            if begin >= end:
                continue
            for tile in range(begin // _TILE, (end - 1) // _TILE + 1):
                if not near[y - first, tile]:
                    near[y - first, tile] = True
                    squares[:, y - first, tile * _TILE : (tile + 1) * _TILE] = np.inf
            for x in range(begin, end, LANES):
                dx = (px - x) - lanes
                d, s = dx * nx + dy * ny, dy * nx - dx * ny
                square = d * d + s * s
                within = (square <= reach * reach) & (absolute(s) <= _HALF + _SPREAD * absolute(d))
                for side in range(sides):
                    nearer = within
                    if not two_sided:
                        nearer = nearer & ((d >= 0.0) if side == 0 else (d < 0.0))
                    if not any_lane(nearer):
                        continue
                    at = (side * rows + y - first) * length + x
                    before = load(square_at, at)
                    nearer = nearer & (square + weaker < before)
                    store(square_at, at, select(nearer, square + weaker, before))
                    store(which_at, at, select(nearer, splat_ints(e), load(which_at, at)))
    keep(squares)
    keep(which)
