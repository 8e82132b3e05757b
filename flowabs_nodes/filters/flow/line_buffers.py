"""Where the passes of the ETF keep what lies between them: rings of rows, small enough for the second-level cache.

A pass reads the rows around its own from the ring that the pass before writes into; what is further behind than its
kernel reaches is written over. The rows are those of a tile of the picture, and as much around it as all later passes
reach.
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


class LineBuffers(NamedTuple):
    """What lies between the passes."""

    words: Int32  # N and ĝN that each pass sums, a ring of rows
    sums: Int32  # over the kernel, in the rows at work
    tangents: Array  # that each pass turns, a ring of rows
    trace: Array  # (1 - ĝ) sum |t|^2 + sum ĝ|t|^2, which never changes from one iteration to the next: a ring of rows


class Layout(NamedTuple):
    """Where it lies."""

    columns: int  # of a row
    margin: int  # of them, to the left of the tile
    depth: int  # rows of the ring of words
    kept: int  # rows of the other rings
    most: int  # groups of a pass
    room: int  # columns of a row of running sums
    pad: int  # of them, to the left of the others
    origin: int  # where column 0 of the picture would be


def tiles_of(height: int, width: int, most: int) -> Int64:
    """Strips of about ``most`` columns, cut for threads to get equal shares: left, right, top, bottom of each."""
    threads = thread_count()
    strips = max(-(-width // most), min(threads, width // 128), 1)
    equal = threads // math.gcd(strips, threads)  # many tiles make shares equal as well
    bands = max(1, min(equal, -(-4 * threads // strips), height // 128))
    columns = -(-width // strips // LANES) * LANES
    lefts = [left for left in range(0, width, columns) if width - left >= LANES]  # the last may be wider
    return np.array(
        [
            (left, right, height * band // bands, height * (band + 1) // bands)
            for band in range(bands)
            for left, right in zip(lefts, [*lefts[1:], width], strict=True)
        ]
    )


def reaches_of(passes: Passes, iterations: int) -> Int64:
    """How far the passes from p on reach together: so much more than a tile have those before to cover."""
    reach = np.tile(passes.reach, (iterations, 1))
    return np.append(np.cumsum(reach[::-1], axis=0)[::-1], [[0, 0]], axis=0)


def layout_of(passes: Passes, tiles: Int64, reaches: Int64) -> tuple[Layout, Int64]:
    """And where, from a group's first sums on, those are that are m to the right and m + 1 to the left."""
    whole = -(-reaches[0, 0] // LANES) * LANES
    margin = int(whole) + LANES
    columns = -(-int(np.max(tiles[:, 1] - tiles[:, 0])) // LANES) * LANES + 2 * margin
    pad = -(-2 * int(np.max(passes.reach[:, 0])) // LANES) * LANES + LANES
    room = columns + pad + LANES
    depth, kept = 2 * int(np.max(passes.reach[:, 1])) + 1 + ROWS, int(reaches[0, 1]) + ROWS
    m = passes.groups[:, 0]
    begins = np.concatenate([np.arange(first[-1] - first[0]) for first in passes.first]) * ROWS * room + pad
    most = int(np.max(passes.first[:, -1] - passes.first[:, 0]))
    return Layout(columns, margin, depth, kept, most, room, pad, 0), np.stack([begins + m, begins - m - 1], axis=1)


@inlined
def whole(columns: int) -> int:
    return (columns + LANES - 1) // LANES * LANES


@kernel
def aligned(size: int) -> Int32:
    """From a whole line of memory on: reading sixteen at a time across two lines takes twice as long."""
    memory = np.empty(size + LANES, np.int32)
    skip = -(memory.ctypes.data // 4) % LANES
    return memory[skip : skip + size]


@inlined
def words_at(layout: Layout, p: int, y: int) -> int:
    """Row y of the first plane that pass p sums; the other planes come after."""
    return (p * layout.depth + y % layout.depth) * PLANES * layout.columns


@inlined
def tangents_at(layout: Layout, p: int, y: int) -> int:
    """Row y of t.x that pass p turns; that of t.y comes after."""
    return (p * layout.kept + y % layout.kept) * 2 * layout.columns


@inlined
def trace_at(layout: Layout, kind: int, y: int) -> int:
    return (kind * layout.kept + y % layout.kept) * layout.columns


@kernel
def clear(numbers: Int32, start: int, end: int) -> None:
    for i in range(start, end, LANES):
        store(numbers, i, splat_ints(0))


@inlined
def clear_words(words: Int32, layout: Layout, p: int, y: int) -> None:
    """What pass p sums of a row beyond the picture."""
    at = words_at(layout, p, y)
    clear(words, at, at + PLANES * layout.columns)
