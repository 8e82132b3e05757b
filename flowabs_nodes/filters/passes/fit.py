"""Straight pieces through the points of an edge: what a staircase of cracks is a picture of.

The direction across an edge is first the mean of the cracks' own around it. Then, in the frame of a point with tangent
t and normal n, the other points p_j of the same stroke lie at s_j = (p_j - p).t, h_j = (p_j - p).n. An edge that bends
from n to n_j on the way has gone aside by h = -(n_j.t / n_j.n) s_j / 2; this is taken off. The line h = a + b s through
what is left, by weighted least squares with w_j = strength_j G(s_j; sigma_m) (n.n_j)^2, is the edge at the point: the
average along the edge, unbiased by bends, and where the stroke ends. Points of another surface take no part, so strokes
end crisply where they meet.
"""

from __future__ import annotations

import math

import numpy as np

from flowabs_nodes.array_types import Float64
from flowabs_nodes.filters.passes.edges import Edges, smoothstep
from flowabs_nodes.filters.passes.near import MOVED, begin_at, begin_rows
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel

_DIRECTION = 1.5  # px, sigma of the mean of directions
_DIRECTION_REACH = 4  # px
_DIRECTION_ROWS = _DIRECTION_REACH + 2  # up and down from a point's row
_SAME_SURFACE = 0.25  # relative difference of depths of neighbouring points on one stroke
_APART = 2.0  # px: points further than this from the tangent are another stroke's
_LEAST_SIGMA = 0.1  # px: no point but the own one counts
_RIDGE = 0.5  # px: slopes of strokes shorter than this lean on their direction
# How much of a long straight stroke must be around a point for it to be no speck, and to be drawn in full.
_SPECK, _STROKE = 0.25, 0.55
_FAINT, _FULL = 0.3, 0.7  # mean strength from which a stroke is drawn, and drawn in full


def directed(edges: Edges, two_sided: bool = False) -> Edges:
    """Return edges with n the mean of the directions around, of the same surface and the same side.

    ``two_sided``: directions have no sign, and the mean is that of their tensors n n^T.
    """
    made = edges._replace(nx=np.empty_like(edges.nx), ny=np.empty_like(edges.ny))
    over_rows(_direct, len(edges.rows) - 1, edges, two_sided, made.nx, made.ny)
    return made


def fitted(edges: Edges, sigma_m: float, two_sided: bool = False) -> Edges:
    """Return edges moved onto the pieces of lines through them.

    Strengths are averaged too, and become less where too little of a stroke is around. ``two_sided``: directions
    across the edge have no sign.
    """
    x, y, nx, ny, strength, touching = (np.empty_like(edges.x) for _ in range(6))
    made = edges._replace(x=x, y=y, nx=nx, ny=ny, strength=strength, touching=touching)
    over_rows(_fit, len(edges.rows) - 1, edges, max(sigma_m, _LEAST_SIGMA), two_sided, made)
    return made


@inlined
def _same_stroke(edges: Edges, e: int, k: int) -> bool:
    """Return whether two points may be of one stroke: their near sides have one id, and about the same depth."""
    u, v = edges.depth[e], edges.depth[k]
    same: bool = edges.surface[e] == edges.surface[k] and abs(u - v) <= _SAME_SURFACE * max(abs(u), abs(v))
    return same


@kernel
def _direct(first: int, last: int, edges: Edges, two_sided: bool, nx: Float64, ny: Float64) -> None:
    """Write the directions of the points of the rows ``first`` .. ``last`` - 1."""
    rows, height = edges.rows, edges.rows.size - 1
    begins = np.empty(2 * _DIRECTION_ROWS + 1, np.int64)
    for row in range(first, last):
        top = begin_rows(rows, row, _DIRECTION_ROWS, begins)
        for e in range(rows[row], rows[row + 1]):
            x, y, ex, ey = edges.x[e], edges.y[e], edges.nx[e], edges.ny[e]
            sx, sy = 0.0, 0.0
            for j in range(max(int(y) - _DIRECTION_REACH - 1, 0), min(int(y) + _DIRECTION_REACH + 2, height)):
                for k in range(begin_at(begins, j - top, rows[j + 1], edges.x, x - _DIRECTION_REACH), rows[j + 1]):
                    dx, dy = edges.x[k] - x, edges.y[k] - y
                    if dx > _DIRECTION_REACH:
                        break
                    if dx * dx + dy * dy > _DIRECTION_REACH * _DIRECTION_REACH:
                        continue
                    kx, ky = edges.nx[k], edges.ny[k]
                    if (kx * ex + ky * ey < 0 and not two_sided) or not _same_stroke(edges, e, k):
                        continue
                    if edges.strength[k] == 0:
                        continue
                    w = edges.strength[k] * math.exp(-(dx * dx + dy * dy) / (2 * _DIRECTION * _DIRECTION))
                    if two_sided:
                        kx, ky = kx * kx - ky * ky, 2 * kx * ky  # the double angle
                    sx, sy = sx + w * kx, sy + w * ky
            size = math.sqrt(sx * sx + sy * sy)
            if size == 0:
                nx[e], ny[e] = ex, ey
            elif two_sided:
                half = 0.5 * math.atan2(sy, sx)
                nx[e], ny[e] = math.cos(half), math.sin(half)
            else:
                nx[e], ny[e] = sx / size, sy / size


@kernel
def _fit(first: int, last: int, edges: Edges, sigma: float, two_sided: bool, made: Edges) -> None:
    """Write the fitted points of the rows ``first`` .. ``last`` - 1."""
    rows, height, reach = edges.rows, edges.rows.size - 1, 3 * sigma
    most = math.ceil(reach + MOVED) + 2  # rows up and down from a point's
    begins = np.empty(2 * most + 1, np.int64)
    for row in range(first, last):
        top = begin_rows(rows, row, most, begins)
        for e in range(rows[row], rows[row + 1]):
            x, y, nx, ny = edges.x[e], edges.y[e], edges.nx[e], edges.ny[e]
            count, w0, w1, w2, h0, h1, both = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for j in range(max(math.floor(y - reach - MOVED), 0), min(math.floor(y + reach + MOVED) + 1, height)):
                for k in range(begin_at(begins, j - top, rows[j + 1], edges.x, x - reach), rows[j + 1]):
                    dx, dy = edges.x[k] - x, edges.y[k] - y
                    if dx > reach + MOVED:
                        break
                    if abs(dx) > reach or abs(dy) > reach:
                        continue
                    s, h = dy * nx - dx * ny, dx * nx + dy * ny
                    alike = nx * edges.nx[k] + ny * edges.ny[k]
                    if two_sided:
                        alike = abs(alike)
                    if alike < 0.5 or abs(s) > reach or abs(h) > _APART or not _same_stroke(edges, e, k):
                        continue
                    bend = (nx * edges.ny[k] - ny * edges.nx[k]) / (nx * edges.nx[k] + ny * edges.ny[k])
                    h += 0.5 * s * bend
                    g = alike * alike * math.exp(-s * s / (2 * sigma * sigma))
                    w = edges.strength[k] * g
                    count, w0, w1, w2, h0, h1 = (
                        count + g,
                        w0 + w,
                        w1 + w * s,
                        w2 + w * s * s,
                        h0 + w * h,
                        h1 + w * s * h,
                    )
                    both += w * edges.touching[k]
            b = (w0 * h1 - w1 * h0) / (w0 * w2 - w1 * w1 + (_RIDGE * w0) ** 2) if w0 > 0 else 0.0
            a = (h0 - b * w1) / w0 if w0 > 0 else 0.0
            made.x[e], made.y[e] = x + a * nx, y + a * ny
            made.touching[e] = both / w0 if w0 > 0 else 0.0
            size = math.sqrt(1 + b * b)
            made.nx[e], made.ny[e] = (nx + b * ny) / size, (ny - b * nx) / size  # n - b t, t = (-n.y, n.x)
            whole = sigma * math.sqrt(2 * math.pi) * max(abs(nx), abs(ny))  # the sum of g on a long line
            made.strength[e] = smoothstep(_FAINT, _FULL, w0 / count) * smoothstep(_SPECK, _STROKE, count / whole)
