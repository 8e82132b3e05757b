"""Tiles of a picture, and the line buffers through which the passes of the ETF hand rows to each other.

A line buffer holds the last few rows of what one pass has made, as many as the next pass reads: row y lies where row
y - n lay before, n the number of rows in the buffer. So all passes of a tile run through the second-level cache. A tile
has a *halo*: each pass works on so many pixels around the tile as the passes after it reach.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array, Int32, Int64
from flowabs_nodes.filters.flow.footprint_sums import PLANES, ROWS, Passes
from flowabs_nodes.simd.bands import thread_count
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, splat_ints
from flowabs_nodes.simd.memory import store

_TILE_ROWS = 1080  # at most: work that is asked to stop ends after the tiles that have begun


class LineBuffers(NamedTuple):
    """What the passes of a tile hand to each other, each array flattened; "steps" are all passes of all iterations."""

    terms: Int32  # (steps, term_rows, PLANES, columns): the planes that each pass sums, in fixed point
    sums: Int32  # (sizes, PLANES, ROWS, columns): their sums over the footprints, for the four rows at work
    tangents: Array  # (steps, tangent_rows, 2, columns): t.x and t.y before each pass but the first
    trace: Array  # (passes of an iteration, tangent_rows, columns): the trace of M (etf_passes.py), the same in each


class Layout(NamedTuple):
    """The sizes of the line buffers of a tile."""

    columns: int  # of a row, a multiple of sixteen
    margin: int  # number of columns to the left of the tile
    term_rows: int
    tangent_rows: int
    groups: int  # most groups of rows in any pass (see footprint_sums.py)
    running_columns: int  # of a row of running sums
    running_margin: int  # number of columns of running sums to the left of column 0 of the terms


class Plan(NamedTuple):
    """How a picture is cut into tiles, and how a tile is laid out in memory."""

    tiles: Int64  # (tiles, 4): left, right, top, bottom
    halos: Int64  # (steps + 1, 2): columns and rows around a tile in which the terms of each pass are needed
    layout: Layout
    edges: Int64  # see Footprints


def whole_vectors(columns: int) -> int:
    """Round up to a multiple of sixteen."""
    return (columns + LANES - 1) // LANES * LANES


whole_vectors_inlined = inlined(whole_vectors)  # for kernels; Python cannot call it


def tiles_of(height: int, width: int, columns: int) -> Int64:
    """Cut a picture, at least sixteen pixels wide, into tiles of about ``columns`` columns, an equal share per thread.

    Returns (tiles, 4): left, right, top and bottom of each tile, the last column and row not included. Every left is a
    multiple of sixteen, and every tile at least sixteen pixels wide.
    """
    threads = thread_count()
    strips = max(-(-width // columns), min(threads, width // 128), 1)
    equal = threads // math.gcd(strips, threads)  # bands that give each thread as many tiles; many tiles do so as well
    bands = max(1, min(equal, -(-4 * threads // strips), height // 128))
    bands *= -(-height // (bands * _TILE_ROWS))
    whole = whole_vectors(-(-width // strips))
    lefts = [left for left in range(0, width, whole) if width - left >= LANES]  # the last tile may be wider
    return np.array(
        [
            (left, right, height * band // bands, height * (band + 1) // bands)
            for band in range(bands)
            for left, right in zip(lefts, [*lefts[1:], width], strict=True)
        ]
    )


def halos_of(passes: Passes, iterations: int) -> Int64:
    """Return how many columns and rows the passes from each one on reach together: (steps + 1, 2), the last (0, 0)."""
    reach = np.tile(passes.reach, (iterations, 1))
    return np.append(np.cumsum(reach[::-1], axis=0)[::-1], [[0, 0]], axis=0)


def plan_of(passes: Passes, tiles: Int64, halos: Int64) -> Plan:
    """Lay out line buffers that are large enough for every one of ``tiles`` and its halo."""
    margin = whole_vectors(int(halos[0, 0])) + LANES
    columns = whole_vectors(int(np.max(tiles[:, 1] - tiles[:, 0]))) + 2 * margin
    reach_x, reach_y = np.max(passes.reach, axis=0).tolist()
    running_margin = whole_vectors(2 * reach_x) + LANES
    layout = Layout(
        columns=columns,
        margin=margin,
        term_rows=2 * reach_y + 1 + ROWS,
        tangent_rows=int(halos[0, 1]) + ROWS,
        groups=int(np.max(passes.first[:, -1] - passes.first[:, 0])),
        running_columns=columns + running_margin + LANES,
        running_margin=running_margin,
    )
    group = np.concatenate([np.arange(first[-1] - first[0]) for first in passes.first])
    begin = group * ROWS * layout.running_columns + running_margin
    m = passes.groups[:, 0]
    return Plan(tiles, halos, layout, np.stack([begin + m, begin - m - 1], axis=1))


@inlined
def new_line_buffers(layout: Layout, kinds: int, sizes: int, steps: int) -> LineBuffers:
    """Return memory for a tile: for ``kinds`` passes in an iteration, ``sizes`` footprints each, ``steps`` in all."""
    return LineBuffers(
        new_aligned(steps * layout.term_rows * PLANES * layout.columns),
        new_aligned(sizes * PLANES * ROWS * layout.columns),
        np.empty(steps * layout.tangent_rows * 2 * layout.columns, np.float32),
        np.empty(kinds * layout.tangent_rows * layout.columns, np.float32),
    )


@kernel
def new_aligned(size: int) -> Int32:
    """Return ``size`` int32 that begin with a cache line: reading sixteen across two lines takes twice as long."""
    memory = np.empty(size + LANES, np.int32)
    skip = -(memory.ctypes.data // 4) % LANES
    return memory[skip : skip + size]


@inlined
def terms_at(layout: Layout, p: int, y: int) -> int:
    """Return the index of row y of the first plane of terms that pass ``p`` sums; each plane is ``columns`` further."""
    return (p * layout.term_rows + y % layout.term_rows) * PLANES * layout.columns


@inlined
def tangents_at(layout: Layout, p: int, y: int) -> int:
    """Return the index of row y of t.x before pass ``p``; t.y is ``columns`` further."""
    return (p * layout.tangent_rows + y % layout.tangent_rows) * 2 * layout.columns


@inlined
def trace_at(layout: Layout, kind: int, y: int) -> int:
    """Return the index of row y of the trace of M in pass ``kind`` of an iteration."""
    return (kind * layout.tangent_rows + y % layout.tangent_rows) * layout.columns


@kernel
def clear(numbers: Int32, start: int, end: int) -> None:
    """Write zeros from ``start`` to ``end``, a multiple of sixteen further."""
    for i in range(start, end, LANES):
        store(numbers, i, splat_ints(0))


@inlined
def clear_terms(terms: Int32, layout: Layout, p: int, first: int, last: int) -> None:
    """Write zeros into the rows ``first`` .. ``last`` - 1 of the terms that pass ``p`` sums: outside the picture."""
    for y in range(first, last):
        at = terms_at(layout, p, y)
        clear(terms, at, at + PLANES * layout.columns)
