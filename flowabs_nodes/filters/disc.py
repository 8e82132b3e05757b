"""The kernels that the ETF sums over, and how sums over them go down a picture.

A kernel is columns: the pixels (dx, dy) with \\|dy\\| <= v(dx). Columns of the same height are a group. The running sum
of a group and a column of the picture is that of the row above, plus the pixel v below, minus the one v + 1 above
(:func:`slide`); the kernel's sum at x is that of the running sums at x + dx, each of its own group (:func:`gather`).
In integers nothing drifts: the sums are the same bits wherever one begins.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.filters.kernels import kernel
from flowabs_nodes.filters.vector import LANES, load, same_ints, store

Int32 = npt.NDArray[np.int32]
Int64 = npt.NDArray[np.int64]

u = np.uintp  # unsigned indices do not wrap around, which would cost time
PLANES = 6  # that may be summed
ROWS = 4  # that are done together: neighbouring rows read nearly the same, and loops cost less


class Passes(NamedTuple):
    """The passes of one iteration, and in each the kernels of every size."""

    reach: Int64  # (passes, 2): how far it reaches to the side, and up and down
    first_group: Int64  # (passes + 1,)
    height: Int64  # v of each group
    first_tap: Int64  # (passes, sizes + 1)
    group: Int64  # of each tap, counted from the first group of the pass
    dx: Int64  # of each tap
    pixels: int  # of the largest kernel


def passes(kernel: str, radii: list[float], height: int, width: int) -> Passes:
    """Of an iteration on a picture of this size: "full", a disc, or "separable", a row, then a column."""
    shapes = [[_disc(r, height, width)] if kernel == "full" else _cross(r, height, width) for r in radii]
    reach: list[tuple[int, int]] = []
    heights: list[int] = []
    group: list[int] = []
    dx: list[int] = []
    first_group, first_tap, pixels = [0], [], 1
    for sizes in zip(*shapes, strict=True):
        reach.append((max(len(v) for v in sizes) - 1, max(v[0] for v in sizes)))
        taps = [len(dx)]
        for v in sizes:
            columns = range(1 - len(v), len(v))
            for k in columns:
                if v[abs(k)] not in heights[first_group[-1] :]:
                    heights.append(v[abs(k)])
                group.append(heights.index(v[abs(k)], first_group[-1]) - first_group[-1])
                dx.append(k)
            taps.append(len(dx))
            pixels = max(pixels, sum(2 * v[abs(k)] + 1 for k in columns))
        first_group.append(len(heights))
        first_tap.append(taps)
    return Passes(
        np.array(reach),
        np.array(first_group),
        np.array(heights),
        np.array(first_tap),
        np.array(group),
        np.array(dx),
        pixels,
    )


def _disc(radius: float, height: int, width: int) -> list[int]:
    """Eq. 2: v(0), v(1) .. of the pixels with dx^2 + dy^2 < radius^2, as far as a picture of this size has them."""
    radius = min(radius, math.hypot(height, width) + 1)
    columns = []
    for k in range(min(_steps(radius), width - 1) + 1):
        v = _steps(math.sqrt(radius * radius - k * k))
        v += k * k + (v + 1) ** 2 < radius * radius  # the root may round either way
        v -= k * k + v * v >= radius * radius
        columns.append(min(v, height - 1))
    return columns


def _cross(radius: float, height: int, width: int) -> list[list[int]]:
    """A row and a column of the pixels with \\|d\\| < radius."""
    radius = min(radius, height + width)
    return [[0] * (min(_steps(radius), width - 1) + 1), [min(_steps(radius), height - 1)]]


def _steps(radius: float) -> int:
    """The largest d < radius."""
    return math.ceil(radius) - 1


@kernel
def enter_and_leave(height: Int64, y: int, depth: int, row: int, entering: Int64, leaving: Int64) -> None:
    """Where in a ring of ``depth`` rows those are that enter and leave the running sums of rows y .. y + 3."""
    for j in range(height.size):
        for k in range(ROWS):
            entering[j, k] = (y + k + height[j]) % depth * row
            leaving[j, k] = (y + k - height[j] - 1) % depth * row


@kernel
def slide(
    words: Int32,
    entering: Int64,
    leaving: Int64,
    planes: int,
    groups: int,
    running: Int32,
    most: int,
    start: int,
    end: int,
    columns: int,
) -> None:
    """The running sums of rows y .. y + 3, from that of row y - 1, at the columns ``start`` .. ``end`` - 1.

    ``running`` has four rows of ``columns`` for each group, and room for ``most`` groups in each plane.
    """
    for plane in range(planes):
        for j in range(groups):
            for k in range(0, ROWS, 2):  # by two: more addresses than registers would be slower
                into = ((plane * most + j) * ROWS + k) * columns
                before = ((plane * most + j) * ROWS + (k - 1) % ROWS) * columns
                b0, b1 = plane * columns + entering[j, k], plane * columns + entering[j, k + 1]
                a0, a1 = plane * columns + leaving[j, k], plane * columns + leaving[j, k + 1]
                for x in range(start, end, LANES):
                    s0 = load(running, before + x) + (load(words, b0 + x) - load(words, a0 + x))
                    s1 = s0 + (load(words, b1 + x) - load(words, a1 + x))
                    store(running, into + x, s0)
                    store(running, into + columns + x, s1)


@kernel
def gather(
    running: Int32,
    place: Int64,
    taps: Int64,
    planes: int,
    most: int,
    sums: Int32,
    start: int,
    end: int,
    columns: int,
) -> None:
    """The sums over the kernels in these four rows, from the running sums at their taps: by size, plane and row."""
    for size in range(taps.size - 1):
        for plane in range(planes):
            of, into = plane * most * ROWS * columns, (size * PLANES + plane) * ROWS * columns
            for x in range(start, end, LANES):
                s0, s1, s2, s3 = same_ints(0), same_ints(0), same_ints(0), same_ints(0)
                for k in range(taps[size], taps[size + 1]):
                    i = place[u(k)] + (of + x)
                    s0, s1 = s0 + load(running, i), s1 + load(running, i + columns)
                    s2, s3 = s2 + load(running, i + 2 * columns), s3 + load(running, i + 3 * columns)
                i = into + x
                store(sums, i, s0)
                store(sums, i + columns, s1)
                store(sums, i + 2 * columns, s2)
                store(sums, i + 3 * columns, s3)
