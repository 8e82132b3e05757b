"""Eq. 1, all iterations in one go: tiles of the picture, whose passes follow each other down the rows.

A pass works on four rows at once, as far behind the pass before as its kernel reaches. What it needs of that one lies
in rings of rows, small enough for the second-level cache; from memory every pixel is read once and written once. A
tile covers its surroundings too, as far as all later passes reach; beyond the picture there are no tangents.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array, Int32, Int64
from flowabs_nodes.filters.flow.footprint_sums import PLANES, ROWS, Passes, sum_over_footprints
from flowabs_nodes.filters.flow.line_buffers import (
    Layout,
    LineBuffers,
    aligned,
    clear,
    clear_words,
    layout_of,
    reaches_of,
    tangents_at,
    tiles_of,
    trace_at,
    whole,
    words_at,
)
from flowabs_nodes.simd.avx512 import approximate_rsqrt
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, bits_of, minimum, select, splat_floats, to_floats
from flowabs_nodes.simd.memory import load, load_pairs, prefetch, prefetch_for_write, store, store_pairs

COLUMNS = 400  # of a tile, about: what its passes leave for each other stays in the second-level cache
WIDER = 10  # times as wide as what it covers beside it, at least
REACH = 64  # pixels that the passes reach together which are done in one go


class Field(NamedTuple):
    """What the passes read of the picture: each plane as one row."""

    tangent: Array
    magnitude: Array
    inverse: np.float32  # of the gradient's reference
    choice: Int32  # which size of kernel each pixel takes
    height: int
    width: int


class FixedPoint(NamedTuple):
    """How numbers are made whole: so finely that no sum over a kernel reaches 2^31."""

    one: np.float32
    # Small kernels have room for |t|^2, from bit ``trace_bit`` on, and ĝ|t|^2 in one number; with 0 there are two.
    trace_bit: int
    one_below: np.float32


def smooth(
    tangent: Array, magnitude: Array, reference: float, iterations: int, passes: Passes, choice: Int32 | None = None
) -> Array:
    """Smooth the tangents of a gradient (section 2.3): (H, W, 2).

    ``choice``, (H, W), tells which of the sizes of ``passes`` each pixel takes.
    """
    height, width = magnitude.shape
    if choice is None:
        choice = np.zeros((1, 1), np.int32)
    elif width < LANES:
        choice = np.pad(choice, [(0, 0), (0, LANES - width)])
    if width < LANES:  # beside the picture there are no tangents
        beside = [(0, 0), (0, LANES - width)]
        tangent, magnitude = np.pad(tangent, [*beside, (0, 0)]), np.pad(magnitude, beside)
    columns = magnitude.shape[1]
    # Next to no reference gives ĝ = 1 wherever there is a gradient, and none gives ĝ = 0.
    inverse = np.float32(min(1 / reference, float(np.finfo(np.float32).max)) if reference > 0 else 0)
    bits = passes.pixels.bit_length()
    one, below = min(20, 30 - bits), min(20, 31 - 2 * bits)
    fixed = FixedPoint(np.float32(2.0**one), bits + below if below >= 15 else 0, np.float32(2.0 ** max(below, 0)))
    at_once = max(1, int(REACH // max(1, passes.reach.sum(axis=0).max())))
    smoothed = np.empty_like(tangent)
    while iterations > 0:
        now = min(iterations, at_once)
        field = Field(tangent.reshape(-1), magnitude.reshape(-1), inverse, choice.reshape(-1), height, columns)
        beyond = reaches_of(passes, now)
        tiles = tiles_of(height, columns, max(COLUMNS, WIDER * int(beyond[0, 0])))
        layout, ends = layout_of(passes, tiles, beyond)
        arguments = tiles, passes, beyond, layout, ends, field, fixed, smoothed.reshape(-1)
        over_rows(_smooth, len(tiles), *arguments, least=1)
        tangent, smoothed, iterations = smoothed, tangent, iterations - now
    return np.ascontiguousarray(tangent[:, :width])


@kernel
def _smooth(
    first: int,
    last: int,
    tiles: Int64,
    passes: Passes,
    beyond: Int64,
    shared: Layout,
    ends: Int64,
    field: Field,
    fixed: FixedPoint,
    smoothed: Array,
) -> None:
    """The tiles ``first`` .. ``last`` - 1."""
    kinds, sizes, steps = passes.first.shape[0], passes.first.shape[1] - 1, beyond.shape[0] - 1
    columns, margin, depth, kept, most, room, pad, _ = shared
    words = aligned(steps * depth * PLANES * columns)
    running = aligned(steps * PLANES * most * ROWS * room)
    sums = aligned(sizes * PLANES * ROWS * columns)
    tangents = np.empty(steps * kept * 2 * columns, np.float32)
    trace = np.empty(kinds * kept * columns, np.float32)
    memory = LineBuffers(words, sums, tangents, trace)
    rows = np.empty(depth, np.int64)
    for tile in range(first, last):
        left, right, top, bottom = tiles[tile, 0], tiles[tile, 1], tiles[tile, 2], tiles[tile, 3]
        clear(words, 0, words.size)
        clear(running, 0, running.size)
        layout = Layout(columns, margin, depth, kept, most, room, pad, margin - left)
        for newest in range(max(top - beyond[0, 1], 0), bottom + beyond[0, 1], ROWS):
            start, end = max(left - whole(beyond[0, 0]), 0), min(right + beyond[0, 0], field.width)
            _begin(newest, min(newest + ROWS, field.height), start, end, field, fixed, words, layout)
            for y in range(max(newest, field.height), newest + ROWS):
                clear_words(words, layout, 0, y)
            y0 = newest
            for p in range(steps):
                kind = p % kinds
                y0 -= passes.reach[kind, 1]
                first_row, last_row = max(top - beyond[p + 1, 1], 0), min(bottom + beyond[p + 1, 1], field.height)
                start, end = max(left - whole(beyond[p + 1, 0]), 0), min(right + beyond[p + 1, 0], field.width)
                x0, x1 = layout.origin + start, layout.origin + start + whole(end - start)
                before = layout.origin + max(left - whole(beyond[p, 0]), 0)
                middle = passes.reach[kind, 1] + 1
                for d in range(2 * middle + ROWS - 1):
                    rows[d] = (p * depth + (y0 + d - middle) % depth) * PLANES * columns
                planes = 4 if p >= kinds else 5 if fixed.trace_bit > 0 else PLANES
                down = p * PLANES * most * ROWS * room
                sum_over_footprints(
                    words, rows, middle, planes, passes.groups, passes.first[kind], ends,
                    running, down, most, room, pad, sums, before, x0, x1, columns,
                )  # fmt: skip
                ready = max(y0, first_row), min(y0 + ROWS, last_row)
                _turn(p, kinds, steps, sizes, y0, ready, start, end, field, fixed, memory, layout, smoothed)
                if y0 + ROWS <= first_row:
                    break  # the next pass has nothing to read yet
                if p + 1 < steps:
                    for y in range(max(y0, field.height), y0 + ROWS):
                        clear_words(words, layout, p + 1, y)


# The equations. -----------------------------------------------------------------------------------------------------
# What is done for each sixteen pixels takes no tuples of arrays: numba would count references to them at every call.


@kernel
def _begin(
    first: int, last: int, start: int, end: int, field: Field, fixed: FixedPoint, words: Int32, layout: Layout
) -> None:
    """N and ĝN of the gradient's tangents in the rows ``first`` .. ``last`` - 1, for the first pass."""
    tangent, magnitude, width = field.tangent, field.magnitude, field.width
    for y in range(first, last):
        into = layout.origin + words_at(layout, 0, y)
        for x0 in range(start, end, LANES):
            x = min(x0, width - LANES)
            i = y * width + x
            prefetch(tangent, 2 * (i + ROWS * width))
            prefetch(tangent, 2 * (i + ROWS * width) + LANES)
            prefetch(magnitude, i + ROWS * width)
            tx, ty = load_pairs(tangent, 2 * i)
            g = _strength(magnitude, i, field.inverse)
            _store_words(tx, ty, g, True, fixed, words, into + x, layout.columns)


@kernel
def _turn(
    p: int,
    kinds: int,
    steps: int,
    sizes: int,
    y0: int,
    rows: tuple[int, int],
    start: int,
    end: int,
    field: Field,
    fixed: FixedPoint,
    memory: LineBuffers,
    layout: Layout,
    smoothed: Array,
) -> None:
    """t' = 1/k M t with M = (1 - ĝ) sum N + sum ĝN, from its trace a and its double angle (b, d).

    In the rows ``rows[0]`` .. ``rows[1]`` - 1 of those that begin with y0.
    """
    words, all_sums, tangents, trace = memory
    tangent, magnitude, inverse, choice, _, width = field
    columns, o = layout.columns, layout.origin
    plane = ROWS * columns
    for y in range(rows[0], rows[1]):
        before, after = o + tangents_at(layout, p, y), o + tangents_at(layout, p + 1, y)
        into, of_trace, row = o + words_at(layout, p + 1, y), o + trace_at(layout, p % kinds, y), o + (y - y0) * columns
        for x0 in range(start, end, LANES):
            x = min(x0, width - LANES)
            i, sums = y * width + x, row + x
            g = _strength(magnitude, i, inverse)
            if p == 0:
                tx, ty = load_pairs(tangent, 2 * i)
            else:
                tx, ty = load(tangents, before + x), load(tangents, before + columns + x)
            if p < kinds:
                n = _own_sum(all_sums, sums + 4 * plane, plane, choice, i, sizes)
                if fixed.trace_bit > 0:
                    gn = to_floats(n & ((1 << fixed.trace_bit) - 1)) * (fixed.one / fixed.one_below)
                    a = (1.0 - g) * to_floats(n >> fixed.trace_bit) * fixed.one + gn
                else:
                    gn = to_floats(_own_sum(all_sums, sums + 5 * plane, plane, choice, i, sizes))
                    a = (1.0 - g) * to_floats(n) + gn
                store(trace, of_trace + x, a)
            else:
                a = load(trace, of_trace + x)
            c = to_floats(_own_sum(all_sums, sums, plane, choice, i, sizes))
            gc = to_floats(_own_sum(all_sums, sums + plane, plane, choice, i, sizes))
            s = to_floats(_own_sum(all_sums, sums + 2 * plane, plane, choice, i, sizes))
            gs = to_floats(_own_sum(all_sums, sums + 3 * plane, plane, choice, i, sizes))
            b, d = (1.0 - g) * c + gc, (1.0 - g) * s + gs
            tx, ty = _normalised((a + b) * tx + d * ty, d * tx + (a - b) * ty, tx, ty)
            if p == steps - 1:
                prefetch_for_write(smoothed, 2 * (i + ROWS * width))
                prefetch_for_write(smoothed, 2 * (i + ROWS * width) + LANES)
                store_pairs(smoothed, 2 * i, (tx, ty))
            else:
                store(tangents, after + x, tx)
                store(tangents, after + columns + x, ty)
                _store_words(tx, ty, g, p + 1 < kinds, fixed, words, into + x, columns)


@inlined
def _strength(magnitude: Array, i: int, inverse: float) -> Any:
    """ĝ = min(|g| / reference, 1)."""
    return minimum(load(magnitude, i) * inverse, 1.0)


@inlined
def _store_words(tx: Any, ty: Any, g: Any, trace: bool, fixed: FixedPoint, words: Int32, i: int, columns: int) -> None:
    """N and ĝN by their double angle, c = t.x^2 - t.y^2 and s = 2 t.x t.y, and where it is new, their trace."""
    c, s = (tx * tx - ty * ty) * fixed.one, 2.0 * tx * ty * fixed.one
    store(words, i, _nearest(c))
    store(words, i + columns, _nearest(g * c))
    store(words, i + 2 * columns, _nearest(s))
    store(words, i + 3 * columns, _nearest(g * s))
    if trace:
        there = tx * tx + ty * ty > 0.0  # |t|^2 is 1 or 0
        if fixed.trace_bit > 0:
            store(words, i + 4 * columns, select(there, _nearest(g * fixed.one_below) + (1 << fixed.trace_bit), 0))
        else:
            store(words, i + 4 * columns, _nearest(select(there, splat_floats(fixed.one), 0.0)))
            store(words, i + 5 * columns, _nearest(select(there, g * fixed.one, 0.0)))


@inlined
def _nearest(x: Any) -> Any:
    """Rounded, for less than 2^22 either way: of float32 from 2^23 on there are only the whole numbers."""
    return bits_of(x + 12582912.0) - 0x4B400000


@inlined
def _own_sum(sums: Int32, at: int, plane: int, choice: Int32, pixel: int, sizes: int) -> Any:
    """The sum over the kernel of each pixel's own size."""
    total = load(sums, at)
    for size in range(1, sizes):
        total = select(load(choice, pixel) == size, load(sums, at + size * PLANES * plane), total)
    return total


@inlined
def _normalised(x: Any, y: Any, tx: Any, ty: Any) -> Any:
    """(x, y) at length 1, by a Newton step; (tx, ty) where it is zero."""
    square = x * x + y * y
    inverse = approximate_rsqrt(square)
    x, y = x * inverse, y * inverse
    rest = 0.5 * (1.0 - x * x - y * y)
    there = square > 0.0
    return select(there, x + x * rest, tx), select(there, y + y * rest, ty)
