"""The footprints that eq. 1 sums over (eq. 2), and the sums over them at every pixel of four rows at once.

A footprint is a set of pixels (dx, dy) around a centre; row dy has an extent m: |dx| <= m(dy), and m(-dy) = m(dy). The
paper calls it the kernel of radius mu. Rows of the same extent are a *group*. Sums take two steps:

1. Down the columns, each group's rows are summed at every column. The group in the middle, rows -v .. v, has a running
   sum: that of the row above, plus the terms v rows below, minus those v + 1 rows above. Other groups have few rows.
2. Along the rows, the footprint's sum at x is its sum at x - 1, plus each group's sum at x + m, minus each group's sum
   at x - m - 1.

The terms are integers, so nothing is rounded and nothing drifts: a sum has the same bits wherever the running sums
begin, and an overflow on the way is undone by the subtractions (both are modulo 2^32).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from flowabs_nodes.array_types import Int32, Int64
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.lanes import LANES, last_lane, prefix_sums, splat_ints
from flowabs_nodes.simd.memory import load, store

unsigned = np.uintp  # an index that cannot be negative: numba need not check whether it counts from the end
PLANES = 6  # planes of terms that eq. 1 may need sums of
ROWS = 4  # rows that are summed together: neighbouring rows read nearly the same, and loops cost less


class Passes(NamedTuple):
    """The passes of one iteration of eq. 1, and for each pass the footprints of every size to choose from."""

    reach: Int64  # (passes, 2): the largest |dx| and the largest |dy| of any footprint of the pass
    first: Int64  # (passes, sizes + 1): the groups of size k are first[pass, k] .. first[pass, k + 1] - 1
    groups: Int64  # (groups, 3): extent m, first and last |dy|; a group whose first is 0 has the rows -last .. last
    pixels: int  # number of pixels of the largest footprint


class Footprints(NamedTuple):
    """The footprints of one pass."""

    groups: Int64  # of all passes, see Passes
    first: Int64  # (sizes + 1,): the pass's row of Passes.first
    edges: Int64  # (groups, 2): from x in a plane of running sums to the group's sums at x + m and at x - m - 1


class SourceRows(NamedTuple):
    """The rows of terms that a pass sums, PLANES rows of ``columns`` items (see :func:`sum_over_footprints`) each."""

    terms: Int32
    rows: Int64  # rows[middle + dy]: the index in ``terms`` where row y + dy begins, for the first of the four rows y
    middle: int


class RunningSums(NamedTuple):
    """Sums of groups, (planes, groups, ROWS, columns) flattened: at rows y - 4 .. y - 1, replaced by y .. y + 3."""

    sums: Int32
    start: int  # index in ``sums`` of the sums of this pass
    groups: int  # number of groups that there is room for
    columns: int
    margin: int  # number of columns to the left of column 0 of the terms


class Columns(NamedTuple):
    """Columns of a line buffer."""

    filled: int  # to the left of this column every term is 0
    start: int  # the footprints' sums are wanted at the columns ``start`` .. ``end`` - 1, a multiple of sixteen
    end: int


def footprint_passes(kernel: str, radii: list[float], height: int, width: int) -> Passes:
    """Return the passes of an iteration on a picture of this size, with a footprint for each of ``radii`` (pixels).

    ``kernel`` "full" is one pass over the open disc of eq. 2; "separable" is a pass over a row of pixels, then one over
    a column (section 2.4). No footprint reaches further than the picture is large.
    """
    shapes = [[_disc(r, height, width)] if kernel == "full" else _row_and_column(r, height, width) for r in radii]
    reach: list[tuple[int, int]] = []
    groups: list[tuple[int, int, int]] = []
    first: list[list[int]] = []
    for footprints in zip(*shapes, strict=True):
        reach.append((max(m[0] for m in footprints), max(len(m) for m in footprints) - 1))
        first.append([len(groups)])
        for m in footprints:
            for extent in sorted(set(m), reverse=True):
                rows = [dy for dy in range(len(m)) if m[dy] == extent]
                groups.append((extent, rows[0], rows[-1]))
            first[-1].append(len(groups))
    pixels = max(sum(2 * k + 1 for k in m) * 2 - (2 * m[0] + 1) for footprints in shapes for m in footprints)
    return Passes(np.array(reach), np.array(first), np.array(groups), pixels)


def _disc(radius: float, height: int, width: int) -> list[int]:
    """Return the extents m(0), m(1) .. of the pixels with dx^2 + dy^2 < radius^2 that fit into a picture."""
    radius = min(radius, math.hypot(height, width) + 1)
    extents = []
    for dy in range(min(_steps(radius), height - 1) + 1):
        m = _steps(math.sqrt(radius * radius - dy * dy))  # eq. 2
        m += dy * dy + (m + 1) ** 2 < radius * radius  # the root may have been rounded either way
        m -= dy * dy + m * m >= radius * radius
        extents.append(min(m, width - 1))
    return extents


def _row_and_column(radius: float, height: int, width: int) -> list[list[int]]:
    """Return the extents of the pixels with |dx| < radius in one row, and of those with |dy| < radius in one column."""
    radius = min(radius, height + width)
    return [[min(_steps(radius), width - 1)], [0] * (min(_steps(radius), height - 1) + 1)]


def _steps(radius: float) -> int:
    """Return the largest whole number below ``radius``."""
    return math.ceil(radius) - 1


@kernel
def sum_over_footprints(
    source: SourceRows,
    footprints: Footprints,
    running: RunningSums,
    at: Columns,
    planes: int,
    sums: Int32,
    columns: int,
) -> None:
    """Write the sums of four rows over every footprint of a pass, and bring the running sums four rows further down.

    Parameters
    ----------
    source, footprints, running, at
        The terms, what to sum over, the sums of groups as the call for the four rows above left them, and where.
    planes
        Number of planes of terms, at most PLANES.
    sums
        Receives the sums: (sizes, PLANES, ROWS, columns) flattened.
    columns
        Number of columns of a row of ``source.terms`` and of ``sums``, a multiple of sixteen.
    """
    terms, rows, middle = source
    groups, first, edges = footprints
    carried, start, room, width, margin = running
    reach = 0
    for j in range(first[0], first[first.size - 1]):
        reach = max(reach, groups[j, 0])
    for plane in range(planes):
        o, of_plane = plane * columns, start + plane * room * ROWS * width
        # Step 1, down the columns.
        for j in range(first[0], first[first.size - 1]):
            of_group = of_plane + (j - first[0]) * ROWS * width + margin
            for k in range(0, ROWS, 2):  # two rows at a time: four would need more addresses than there are registers
                into, above = of_group + k * width, of_group + (k - 1) % ROWS * width
                top, bottom = groups[j, 1], groups[j, 2]
                if top == 0:
                    enters0, enters1 = o + rows[middle + k + bottom], o + rows[middle + k + bottom + 1]
                    leaves0, leaves1 = o + rows[middle + k - bottom - 1], o + rows[middle + k - bottom]
                    for x in range(at.filled, at.end + reach, LANES):
                        s0 = load(carried, above + x) + (load(terms, enters0 + x) - load(terms, leaves0 + x))
                        s1 = s0 + (load(terms, enters1 + x) - load(terms, leaves1 + x))
                        store(carried, into + x, s0)
                        store(carried, into + width + x, s1)
                else:
                    for dy in range(top, bottom + 1):
                        below0, below1 = o + rows[middle + k + dy], o + rows[middle + k + dy + 1]
                        above0, above1 = o + rows[middle + k - dy], o + rows[middle + k - dy + 1]
                        for x in range(at.filled, at.end + reach, LANES):
                            s0 = load(terms, below0 + x) + load(terms, above0 + x)
                            s1 = load(terms, below1 + x) + load(terms, above1 + x)
                            if dy > top:
                                s0, s1 = s0 + load(carried, into + x), s1 + load(carried, into + width + x)
                            store(carried, into + x, s0)
                            store(carried, into + width + x, s1)
        # Step 2, along the rows: the prefix sums of what enters and leaves, from where all sums are still 0.
        for size in range(first.size - 1):
            into = (size * PLANES + plane) * ROWS * columns
            s0, s1, s2, s3 = splat_ints(0), splat_ints(0), splat_ints(0), splat_ints(0)
            for x in range(at.start - (at.start - at.filled + reach + LANES - 1) // LANES * LANES, at.end, LANES):
                e0, e1, e2, e3 = splat_ints(0), splat_ints(0), splat_ints(0), splat_ints(0)
                for j in range(first[size], first[size + 1]):
                    enters = of_plane + x + edges[unsigned(j), unsigned(0)]
                    leaves = of_plane + x + edges[unsigned(j), unsigned(1)]
                    e0 = e0 + (load(carried, enters) - load(carried, leaves))
                    e1 = e1 + (load(carried, enters + width) - load(carried, leaves + width))
                    e2 = e2 + (load(carried, enters + 2 * width) - load(carried, leaves + 2 * width))
                    e3 = e3 + (load(carried, enters + 3 * width) - load(carried, leaves + 3 * width))
                s0, s1 = last_lane(s0) + prefix_sums(e0), last_lane(s1) + prefix_sums(e1)
                s2, s3 = last_lane(s2) + prefix_sums(e2), last_lane(s3) + prefix_sums(e3)
                if x >= at.start:
                    i = into + x
                    store(sums, i, s0)
                    store(sums, i + columns, s1)
                    store(sums, i + 2 * columns, s2)
                    store(sums, i + 3 * columns, s3)
