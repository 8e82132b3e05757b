"""Edges: cracks with a direction, from the near side outward, a strength and a kind.

A depth crack's near side is that of its step. Between two ids, and between two materials, the depth of single pixels
does not tell: the near side is found by a vote of all cracks of the same two, Gaussian sigma 3 px, each with its
relative step. Where they touch, all cracks of the two in the picture decide, so that ink does not change sides halfway
round an object, or else the higher id is the near one. Id 0 and the background never are.

Where two touch, neither is in front, and a line belongs to both: its edge is moved outward by half its width, a pixel
at most, so that on the way from a silhouette to a contact the line glides. How far they touch is 1 - smoothstep(0, 1,
|vote|); but an object that is in front nearly all round, and touches in a spot, keeps its outline.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from flowabs_nodes.array_types import Float64, Int32, Int64
from flowabs_nodes.filters.passes.cracks import (
    ALONG_X,
    BEHIND,
    DEPTH,
    FIRST,
    FIRST_DEPTH,
    ID,
    KNOWN_BY,
    MATERIAL,
    NEARER,
    SECOND,
    SECOND_DEPTH,
    SHIFT,
    STEP,
    Cracks,
    X,
    Y,
)
from flowabs_nodes.filters.passes.near import begin_at, begin_rows
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel

#: The kinds of edges.
OUTLINE, OBJECT, MATERIAL_CHANGE, CREASE, INTERSECTION = range(5)
KINDS = 5

_VOTE = 3.0  # px, sigma
_REACH = 9  # px
_ROWS = _REACH + 2  # up and down from a crack's row
_TIE_BREAK = 0.25  # what the whole picture counts beside a step of 1
_IN_FRONT, _ALL_ROUND = 0.7, 0.9  # share of the cracks of two from which one outlines the other where they touch too

#: How far an edge between two that touch is moved, in pixels.
FARTHEST = 1.0


class Edges(NamedTuple):
    """Points on edges, in order of their rows."""

    rows: Int64  # (H + 1,): the points of row y are rows[y] .. rows[y + 1] - 1
    x: Float64
    y: Float64
    nx: Float64  # unit vector across the edge, away from its near side
    ny: Float64
    strength: Float64  # 0 to 1
    surface: Float64  # id of the near side
    depth: Float64  # u of the near side
    touching: Float64  # 0 to 1: how far neither side is in front
    kind: Int32


def edges_of(cracks: Cracks, depth_step: float, has_depth: bool) -> Edges:
    """Return the edges at the middles of the cracks, moved to where the coverage says."""
    table, rows = cracks
    made = new_edges(rows, len(table))
    xs = np.ascontiguousarray(table[:, X])
    over_rows(_decide, len(rows) - 1, table, xs, *_in_all(table), depth_step, has_depth, made)
    return made


def _in_all(table: Float64) -> tuple[Float64, Float64]:
    """Return for each crack which of its two sides is near in most of the picture, the first (1) or the second (-1).

    And how far lines lie between them where they touch: 1, 0 where one is in front nearly all round.
    """
    ties, touching = np.zeros(len(table)), np.zeros(len(table))
    for known_by in (ID, MATERIAL):
        own = table[:, KNOWN_BY] == known_by
        cracks = table[own]
        first, second = cracks[:, FIRST].astype(np.uint64), cracks[:, SECOND].astype(np.uint64)
        higher = np.where(first > second, 1.0, -1.0)
        pair = (np.maximum(first, second) << np.uint64(32)) | np.minimum(first, second)
        _, which = np.unique(pair, return_inverse=True)
        votes = np.bincount(which, weights=higher * np.where(cracks[:, BEHIND] == 0, cracks[:, NEARER], 0))
        ties[own] = np.where(votes[which] < 0, -1.0, 1.0) * higher
        in_front = np.abs(votes) / np.maximum(np.bincount(which), 1)
        touching[own] = np.clip((_ALL_ROUND - in_front) / (_ALL_ROUND - _IN_FRONT), 0, 1)[which]
    return ties, touching


def no_edges(height: int) -> Edges:
    """Return the edges of a picture without any."""
    return new_edges(np.zeros(height + 1, np.int64), 0)


def new_edges(rows: Int64, count: int) -> Edges:
    """Return memory for ``count`` edges."""
    x, y, nx, ny, strength, surface, depth, touching = (np.empty(count) for _ in range(8))
    return Edges(rows, x, y, nx, ny, strength, surface, depth, touching, np.empty(count, np.int32))


def between(edges: Edges, width: float) -> Edges:
    """Return edges moved outward where their sides touch, so that a line of a width lies on both."""
    off = edges.touching * min(width / 2, FARTHEST)
    return edges._replace(x=edges.x + off * edges.nx, y=edges.y + off * edges.ny)


@kernel
def _decide(
    first: int,
    last: int,
    table: Float64,
    xs: Float64,
    ties: Float64,
    touching: Float64,
    depth_step: float,
    has_depth: bool,
    edges: Edges,
) -> None:
    """Write the edges of the cracks of the rows ``first`` .. ``last`` - 1."""
    rows, begins = edges.rows, np.empty(2 * _ROWS + 1, np.int64)
    gauss = np.empty(4 * _REACH * _REACH + 1)
    for k in range(gauss.size):
        gauss[k] = math.exp(-(k / 4) / (2 * _VOTE * _VOTE))
    for y in range(first, last):
        top = begin_rows(rows, y, _ROWS, begins)
        for e in range(rows[y], rows[y + 1]):
            crack = table[e]
            known_by, step, behind = crack[KNOWN_BY], crack[STEP], crack[BEHIND]
            steep = smoothstep(0.25 * depth_step, depth_step, abs(step))
            strength, first_is_near, share, both = 1.0, step > 0, 1.0, 0.0
            if known_by == DEPTH:
                strength = steep
            else:
                vote, share = _vote(table, rows, xs, begins, top, e, depth_step, gauss)
                if has_depth and behind == 0:
                    both = touching[e] * (1 - smoothstep(0, 1, abs(vote)))
                vote += _TIE_BREAK * ties[e]
                first_is_near = behind > 0 if behind != 0 else vote >= 0
            side = 1.0 if first_is_near else -1.0
            if behind != 0:
                kind = OUTLINE
            elif has_depth and known_by != DEPTH and share < 0.5:
                kind = INTERSECTION if known_by == ID else MATERIAL_CHANGE
            else:
                kind = MATERIAL_CHANGE if known_by == MATERIAL and not has_depth else OBJECT
            along_x = crack[ALONG_X]
            edges.x[e] = crack[X] + along_x * crack[SHIFT]
            edges.y[e] = crack[Y] + (1 - along_x) * crack[SHIFT]
            edges.nx[e], edges.ny[e] = side * along_x, side * (1 - along_x)
            edges.strength[e], edges.kind[e] = strength, kind
            edges.touching[e] = both
            edges.surface[e] = crack[FIRST] if first_is_near else crack[SECOND]
            edges.depth[e] = crack[FIRST_DEPTH] if first_is_near else crack[SECOND_DEPTH]


@inlined
def _vote(
    table: Float64, rows: Int64, xs: Float64, begins: Int64, top: int, e: int, depth_step: float, gauss: Float64
) -> tuple[float, float]:
    """Return the vote for the first side of a crack, and how much of the cracks around it has a depth step.

    ``gauss`` holds the weights by four times the squared distance: cracks are half pixels apart.
    """
    own = table[e]
    vote, steps, weights = 0.0, 0.0, 0.0
    y0 = int(own[Y])
    for y in range(max(y0 - _REACH - 1, 0), min(y0 + _REACH + 2, rows.size - 1)):
        for k in range(begin_at(begins, y - top, rows[y + 1], xs, own[X] - _REACH), rows[y + 1]):
            other = table[k]
            dx, dy = other[X] - own[X], other[Y] - own[Y]
            if dx > _REACH:
                break
            if dx * dx + dy * dy > _REACH * _REACH or other[KNOWN_BY] != own[KNOWN_BY]:
                continue
            same = other[FIRST] == own[FIRST] and other[SECOND] == own[SECOND]
            turned = other[FIRST] == own[SECOND] and other[SECOND] == own[FIRST]
            if not (same or turned):
                continue
            w = gauss[int(4 * (dx * dx + dy * dy))]
            vote += w * (other[NEARER] if same else -other[NEARER])
            steps += w * smoothstep(0.25 * depth_step, depth_step, abs(other[STEP]))
            weights += w
    return vote / weights, steps / weights


@inlined
def smoothstep(low: float, high: float, x: float) -> float:
    """Return 0 at ``low`` and below, 1 at ``high`` and above, 3t^2 - 2t^3 between."""
    t = min(max((x - low) / (high - low), 0.0), 1.0)
    return t * t * (3 - 2 * t)
