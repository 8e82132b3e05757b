"""The kernels that the ETF sums over, and how sums over them go down and along a picture.

A kernel is rows: the pixels (dx, dy) with \\|dx\\| <= m(dy). Rows of the same m are a group, and are summed first:
those in the middle as a running sum, that of the row above plus the pixel v below, minus the one v + 1 above; the
others row by row. The kernel's sum at x is that at x - 1, plus the groups' sums m to the right, minus those m + 1 to
the left. In integers nothing drifts: the sums are the same bits wherever one begins, and what overflows on the
way comes back.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from flowabs_nodes.array_types import Int32, Int64
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.lanes import LANES, last_lane, prefix_sums, splat_ints
from flowabs_nodes.simd.memory import load, store

u = np.uintp  # unsigned indices do not wrap around, which would cost time
PLANES = 6  # that may be summed
ROWS = 4  # that are done together: neighbouring rows read nearly the same, and loops cost less


class Passes(NamedTuple):
    """The passes of one iteration, and in each the groups of the kernels of every size."""

    reach: Int64  # (passes, 2): how far it reaches to the side, and up and down
    first: Int64  # (passes, sizes + 1): the first group
    groups: Int64  # m and the rows dy, from the first to the last, of each group: 0 to v of the middle one
    pixels: int  # of the largest kernel


def footprint_passes(kernel: str, radii: list[float], height: int, width: int) -> Passes:
    """Of an iteration on a picture of this size: "full", a disc, or "separable", a row, then a column."""
    shapes = [[_disc(r, height, width)] if kernel == "full" else _cross(r, height, width) for r in radii]
    reach: list[tuple[int, int]] = []
    groups: list[tuple[int, int, int]] = []
    first: list[list[int]] = []
    for sizes in zip(*shapes, strict=True):
        reach.append((max(m[0] for m in sizes), max(len(m) for m in sizes) - 1))
        first.append([len(groups)])
        for m in sizes:
            for width_of in sorted(set(m), reverse=True):
                rows = [dy for dy in range(len(m)) if m[dy] == width_of]
                groups.append((width_of, rows[0], rows[-1]))
            first[-1].append(len(groups))
    pixels = max(sum(2 * k + 1 for k in m) * 2 - (2 * m[0] + 1) for sizes in shapes for m in sizes)
    return Passes(np.array(reach), np.array(first), np.array(groups), pixels)


def _disc(radius: float, height: int, width: int) -> list[int]:
    """Eq. 2: m(0), m(1) .. of the pixels with dx^2 + dy^2 < radius^2, as far as a picture of this size has them."""
    radius = min(radius, math.hypot(height, width) + 1)
    rows = []
    for k in range(min(_steps(radius), height - 1) + 1):
        m = _steps(math.sqrt(radius * radius - k * k))
        m += k * k + (m + 1) ** 2 < radius * radius  # the root may round either way
        m -= k * k + m * m >= radius * radius
        rows.append(min(m, width - 1))
    return rows


def _cross(radius: float, height: int, width: int) -> list[list[int]]:
    """A row and a column of the pixels with \\|d\\| < radius."""
    radius = min(radius, height + width)
    return [[min(_steps(radius), width - 1)], [0] * (min(_steps(radius), height - 1) + 1)]


def _steps(radius: float) -> int:
    """The largest d < radius."""
    return math.ceil(radius) - 1


@kernel
def sum_over_footprints(
    words: Int32,
    rows: Int64,
    middle: int,
    planes: int,
    groups: Int64,
    first: Int64,
    ends: Int64,
    running: Int32,
    down: int,
    most: int,
    room: int,
    pad: int,
    sums: Int32,
    before: int,
    start: int,
    end: int,
    columns: int,
) -> None:
    """The sums of rows y .. y + 3 over the kernels, by size, plane and row, at the columns ``start`` .. ``end`` - 1.

    Row y + dy of what is summed is at ``words[rows[middle + dy]]``; left of the column ``before`` there is nothing.
    From ``running[down]`` on, for each plane and each of ``most`` groups, there are four rows of the groups' sums, at
    first of y - 4 .. y - 1, then of y .. y + 3; ``ends[group]``: where those to the right and left begin.
    """
    reach = 0
    for j in range(first[0], first[first.size - 1]):
        reach = max(reach, groups[j, 0])
    for plane in range(planes):
        o, of_plane = plane * columns, down + plane * most * ROWS * room
        for j in range(first[0], first[first.size - 1]):
            of_group = of_plane + (j - first[0]) * ROWS * room + pad
            for k in range(0, ROWS, 2):  # by two: more addresses than registers would be slower
                into, last = of_group + k * room, of_group + (k - 1) % ROWS * room
                top, bottom = groups[j, 1], groups[j, 2]
                if top == 0:
                    b0, b1 = o + rows[middle + k + bottom], o + rows[middle + k + bottom + 1]
                    a0, a1 = o + rows[middle + k - bottom - 1], o + rows[middle + k - bottom]
                    for x in range(before, end + reach, LANES):
                        s0 = load(running, last + x) + (load(words, b0 + x) - load(words, a0 + x))
                        s1 = s0 + (load(words, b1 + x) - load(words, a1 + x))
                        store(running, into + x, s0)
                        store(running, into + room + x, s1)
                else:
                    for dy in range(top, bottom + 1):
                        b0, b1 = o + rows[middle + k + dy], o + rows[middle + k + dy + 1]
                        a0, a1 = o + rows[middle + k - dy], o + rows[middle + k - dy + 1]
                        for x in range(before, end + reach, LANES):
                            s0, s1 = (
                                load(words, b0 + x) + load(words, a0 + x),
                                load(words, b1 + x) + load(words, a1 + x),
                            )
                            if dy > top:
                                s0, s1 = s0 + load(running, into + x), s1 + load(running, into + room + x)
                            store(running, into + x, s0)
                            store(running, into + room + x, s1)
        for size in range(first.size - 1):
            into = (size * PLANES + plane) * ROWS * columns
            s0, s1, s2, s3 = splat_ints(0), splat_ints(0), splat_ints(0), splat_ints(0)
            for x in range(start - (start - before + reach + LANES - 1) // LANES * LANES, end, LANES):
                e0, e1, e2, e3 = splat_ints(0), splat_ints(0), splat_ints(0), splat_ints(0)
                for j in range(first[size], first[size + 1]):
                    i, out = of_plane + x + ends[u(j), u(0)], of_plane + x + ends[u(j), u(1)]
                    e0 = e0 + (load(running, i) - load(running, out))
                    e1 = e1 + (load(running, i + room) - load(running, out + room))
                    e2 = e2 + (load(running, i + 2 * room) - load(running, out + 2 * room))
                    e3 = e3 + (load(running, i + 3 * room) - load(running, out + 3 * room))
                s0, s1 = last_lane(s0) + prefix_sums(e0), last_lane(s1) + prefix_sums(e1)
                s2, s3 = last_lane(s2) + prefix_sums(e2), last_lane(s3) + prefix_sums(e3)
                if x >= start:
                    i = into + x
                    store(sums, i, s0)
                    store(sums, i + columns, s1)
                    store(sums, i + 2 * columns, s2)
                    store(sums, i + 3 * columns, s3)
