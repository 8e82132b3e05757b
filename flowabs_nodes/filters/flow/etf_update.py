"""One pass of eq. 1 at one block of pixels: the terms to be summed, and the tangents turned by their sums.

With N(y) = t(y) t(y)^T a pass computes, with sums over the pixels y of the footprint at x (derived at the head of
``etf.py``),

    t'(x) = 1/k M t(x),    M = (1 - ĝ(x)) sum N(y) + sum ĝ(y) N(y).

A symmetric 2 x 2 matrix N is given by its trace N.xx + N.yy, here |t|^2, and its *double angle* c = N.xx - N.yy =
t.x^2 - t.y^2 and s = 2 N.xy = 2 t.x t.y. So up to six planes of *terms* are summed: c, ĝc, s, ĝs, |t|^2 and ĝ|t|^2, as
whole numbers in fixed point. The last two are the same in every iteration. Beyond the picture the terms are 0. A mask
multiplies all terms of a pixel.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array, Int32
from flowabs_nodes.filters.flow.footprint_sums import PLANES, ROWS
from flowabs_nodes.filters.flow.line_buffers import Layout, LineBuffers, tangents_at, terms_at, trace_at
from flowabs_nodes.simd.avx512 import approximate_rsqrt
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, Floats, bits_of, minimum, select, splat_floats, to_floats
from flowabs_nodes.simd.memory import load, load_pairs, prefetch, prefetch_for_write, store, store_pairs


class Field(NamedTuple):
    """What the passes read of the picture, each plane flattened; rows are at least sixteen pixels long."""

    tangent: Array  # (H, W, 2)
    magnitude: Array  # (H, W), |g|
    mask: Array  # (H, W), what the weight of each pixel is multiplied by; empty where that is 1
    inverse: np.float32  # 1 / reference: ĝ = min(|g| * inverse, 1)
    choice: Int32  # (H, W), which size of footprint each pixel takes; not read if there is one size
    sizes: int
    height: int
    width: int


class FixedPoint(NamedTuple):
    """What numbers are multiplied by before they are rounded: so finely that no sum over a footprint reaches 2^31."""

    one: np.float32
    # The sums of small footprints leave room for |t|^2 and ĝ|t|^2 in one term: |t|^2 counts from bit ``trace_bit`` on,
    # ĝ|t|^2 times ``one_below`` is in the bits below. With ``trace_bit`` 0 there are two terms, times ``one``.
    trace_bit: int
    one_below: np.float32


class Step(NamedTuple):
    """One pass of all that are done in one go."""

    p: int  # 0 .. steps - 1
    kind: int  # which pass of an iteration: p % kinds
    kinds: int
    steps: int


class Block(NamedTuple):
    """The pixels of the four rows at work: columns ``left`` .. ``right`` - 1 of the rows ``top`` .. ``bottom`` - 1."""

    y: int  # the first of the four rows, of which some may be outside the picture or not needed
    top: int
    bottom: int
    left: int
    right: int
    origin: int  # column of the line buffers that is column 0 of the picture


def fixed_point(pixels: int, fractions: bool = False) -> FixedPoint:
    """Return the finest fixed point in which a sum over ``pixels`` pixels fits into int32.

    ``fractions``: whether |t|^2 may lie between 0 and 1, because of a mask; it then has a term of its own.
    """
    bits = pixels.bit_length()
    one, below = min(20, 30 - bits), min(20, 31 - 2 * bits)
    packed = below >= 15 and not fractions
    return FixedPoint(np.float32(2.0**one), bits + below if packed else 0, np.float32(2.0 ** max(below, 0)))


@kernel
def begin(block: Block, field: Field, fixed: FixedPoint, terms: Int32, layout: Layout) -> None:
    """Write the terms that the first pass sums: those of the gradient's tangents."""
    tangent, magnitude, mask, width = field.tangent, field.magnitude, field.mask, field.width
    for y in range(block.top, block.bottom):
        into = block.origin + terms_at(layout, 0, y)
        for x0 in range(block.left, block.right, LANES):
            x = min(x0, width - LANES)
            i = y * width + x
            prefetch(tangent, 2 * (i + ROWS * width))
            prefetch(tangent, 2 * (i + ROWS * width) + LANES)
            prefetch(magnitude, i + ROWS * width)
            tx, ty = load_pairs(tangent, 2 * i)
            g = _strength(magnitude, i, field.inverse)
            _store_terms(tx, ty, g, True, fixed, terms, into + x, layout.columns)
            if mask.size > 0:
                _weigh_terms(load(mask, i), True, terms, into + x, layout.columns)


@kernel
def turn_tangents(
    step: Step,
    block: Block,
    field: Field,
    fixed: FixedPoint,
    buffers: LineBuffers,
    layout: Layout,
    smoothed: Array,
) -> None:
    """Turn the tangents of a block: t' = 1/k M t, with M given by its trace a and its double angle (b, d).

    The last pass writes them into ``smoothed``, the others into the line buffers, with the terms of the next pass.
    """
    # Inlined functions below take no tuples of arrays: numba would count references to the arrays at every call.
    terms, all_sums, tangents, trace = buffers
    tangent, magnitude, mask, inverse, choice, sizes, _, width = field
    p, kind, kinds, steps = step
    columns, o = layout.columns, block.origin
    plane = ROWS * columns
    for y in range(block.top, block.bottom):
        before, after = o + tangents_at(layout, p, y), o + tangents_at(layout, p + 1, y)
        into, of_trace = o + terms_at(layout, p + 1, y), o + trace_at(layout, kind, y)
        row = o + (y - block.y) * columns
        for x0 in range(block.left, block.right, LANES):
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
            b, d = (1.0 - g) * c + gc, (1.0 - g) * s + gs  # eq. 3: 2 w_m = (1 - ĝ(x)) + ĝ(y)
            tx, ty = _normalised((a + b) * tx + d * ty, d * tx + (a - b) * ty, tx, ty)  # eq. 1
            if p == steps - 1:
                prefetch_for_write(smoothed, 2 * (i + ROWS * width))
                prefetch_for_write(smoothed, 2 * (i + ROWS * width) + LANES)
                store_pairs(smoothed, 2 * i, (tx, ty))
            else:
                store(tangents, after + x, tx)
                store(tangents, after + columns + x, ty)
                _store_terms(tx, ty, g, p + 1 < kinds, fixed, terms, into + x, columns)
                if mask.size > 0:
                    _weigh_terms(load(mask, i), p + 1 < kinds, terms, into + x, columns)


@inlined
def _strength(magnitude: Array, i: int, inverse: float) -> Any:
    """Return ĝ = min(|g| / reference, 1) of the sixteen pixels from i on."""
    return minimum(load(magnitude, i) * inverse, 1.0)


@inlined
def _store_terms(tx: Any, ty: Any, g: Any, trace: bool, fixed: FixedPoint, terms: Int32, i: int, columns: int) -> None:
    """Write the terms of sixteen tangents (tx, ty) of strength g, the first plane at ``terms[i]``.

    ``trace``: whether to write |t|^2 and ĝ|t|^2 too. They are the same in every iteration.
    """
    c, s = (tx * tx - ty * ty) * fixed.one, 2.0 * tx * ty * fixed.one  # eq. 4 # eq. 5: φ w_d t(y) = N(y) t(x)
    store(terms, i, _rounded(c))
    store(terms, i + columns, _rounded(g * c))
    store(terms, i + 2 * columns, _rounded(s))
    store(terms, i + 3 * columns, _rounded(g * s))
    if trace:
        there = tx * tx + ty * ty > 0.0  # |t|^2 is 1 or 0
        if fixed.trace_bit > 0:
            store(terms, i + 4 * columns, select(there, _rounded(g * fixed.one_below) + (1 << fixed.trace_bit), 0))
        else:
            store(terms, i + 4 * columns, _rounded(select(there, splat_floats(fixed.one), 0.0)))
            store(terms, i + 5 * columns, _rounded(select(there, g * fixed.one, 0.0)))


@inlined
def _weigh_terms(weight: Floats, trace: bool, terms: Int32, i: int, columns: int) -> None:
    """Multiply the terms that :func:`_store_terms` has written, each in a plane of its own, by a weight from 0 to 1."""
    for plane in range(6 if trace else 4):
        at = i + plane * columns
        store(terms, at, _rounded(to_floats(load(terms, at)) * weight))


@inlined
def _rounded(x: Any) -> Any:
    """Return the whole numbers nearest to floats of less than 2^22 either way.

    Between 2^23 and 2^24 a float32 has no places after the point: adding 1.5 * 2^23 rounds, and the lowest bits count.
    """
    return bits_of(x + 12582912.0) - 0x4B400000


@inlined
def _own_sum(sums: Int32, at: int, plane: int, choice: Int32, pixel: int, sizes: int) -> Any:
    """Return the sums of sixteen pixels, each over the footprint of its own size.

    The sums over the smallest size number, 0, are at ``sums[at]``; a plane, four rows, has ``plane`` items.
    """
    total = load(sums, at)
    for size in range(1, sizes):
        total = select(load(choice, pixel) == size, load(sums, at + size * PLANES * plane), total)
    return total


@inlined
def _normalised(x: Any, y: Any, tx: Any, ty: Any) -> Any:
    """Return the vectors (x, y) at length 1, by one Newton step on an estimate; (tx, ty) where (x, y) is zero."""
    square = x * x + y * y
    inverse = approximate_rsqrt(square)
    x, y = x * inverse, y * inverse
    rest = 0.5 * (1.0 - x * x - y * y)
    there = square > 0.0
    return select(there, x + x * rest, tx), select(there, y + y * rest, ty)
