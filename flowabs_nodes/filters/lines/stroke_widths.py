"""How wide a pen would draw each pixel of a drawing, by the length of its stroke and the way to the stroke's end.

From each pixel of ink z walks along the flow, both ways, and counts ink k(z) until the stroke has ended:

    p <- p (1 - lambda (1 - q)),  e <- e + p q,  q = min(1, 2 k(z))

p is the share of the stroke that has survived. Paper takes it away, over ``gap`` pixels to 1/e: lambda = 1 -
exp(-1 / gap). So a gap of a pixel ends no stroke, and nothing happens at once while a picture moves. A streamline
leaves a thin line before long; z therefore keeps to the middle of the ink: after each step it goes by
(k(z + n) - k(z - n)) / 2 along the normal n.

The lengths of both ways, e and e', make the width w of a stroke, as a part of its own:

    w = smoothstep(1/2, 3/2, (e + e' + 1) / min_length) u (2 - u),  u = min((min(e, e') + 1/2) / taper, 1)
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array, Complex64, Int32
from flowabs_nodes.filters.lines.stroke_lengths import LONGEST, SHORTEST, gap, longest_walk, widest
from flowabs_nodes.sampling.coords import Raster
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import (
    LANES,
    Floats,
    Ints,
    absolute,
    any_lane,
    floor,
    maximum,
    minimum,
    rint,
    select,
    splat_floats,
    splat_ints,
    to_ints,
)
from flowabs_nodes.simd.memory import gather_pairs, load, scratch, store

#: The share of a stroke below which it has ended.
ENDED = np.float32(1 / 64)

#: Ink below this is no stroke of its own: it goes with the strokes around it.
FAINT = np.float32(1 / 64)

# The middle of a stroke: |d| up to this part of its width W, and up to so many pixels in any case, twice.
_MIDDLE, _MIDDLE_PIXELS = np.float32(0.55), np.float32(1.2)


class Rule(NamedTuple):
    """What makes a stroke: lengths in pixels, 0 for what does not count."""

    min_length: np.float32
    taper: np.float32
    fade: np.float32  # lambda
    steps: int  # the longest walk
    reach: int  # the longest way across
    strength: np.float32  # response at which a stroke has its full width

    @classmethod
    def of(cls, min_length: float, taper: float, strength: float) -> Rule:
        """Return the rule for lengths in pixels and a response in code values."""
        length = gap(min_length, taper)
        fade = 1 - math.exp(-1 / length) if length > 0 else 1.0
        steps, reach = longest_walk(min_length, taper), widest(min_length, taper)
        return cls(np.float32(min_length), np.float32(taper), np.float32(fade), steps, reach, np.float32(strength))


class Block(NamedTuple):
    """Sixteen pixels anywhere in a row."""

    x: Ints
    y: Ints


@inlined
def ink_columns(ink: Array, y: int, least: float, raster: Raster, columns: Int32) -> int:
    """Write the columns of row y with at least so much ink to ``columns``, and return how many there are."""
    count = 0
    for x in range(raster.width):
        if ink[y * raster.stride + x] >= least:
            columns[count] = x
            count += 1
    fill_block(columns, count)
    return count


@inlined
def fill_block(columns: Int32, count: int) -> None:
    """Repeat the last of ``count`` columns up to a whole block of sixteen."""
    for k in range(count, count + (-count) % LANES):
        columns[k] = columns[count - 1]


@inlined
def measure_across(ink: Array, flow: Complex64, block: Block, reach: int, raster: Raster, place: Int32) -> Any:
    """Return how much ink lies from a block's pixels to the paper on both sides, across the flow, in pixels."""
    store(place, 0, block.y * raster.stride + block.x)
    tx, ty = gather_pairs(flow, place, 0)
    nothing = splat_floats(0.0)
    one = _across(ink, block, ty, -tx, nothing, reach, raster, place)
    return one, _across(ink, block, -ty, tx, nothing, reach, raster, place)


@inlined
def _across(
    ink: Array, block: Block, nx: Floats, ny: Floats, total: Floats, reach: int, raster: Raster, place: Int32
) -> Floats:
    """Return how much ink lies in the direction (nx, ny); ``total`` is 0."""
    survival = splat_floats(1.0)
    for s in range(1, reach + 1):
        q = ink_at(ink, block, nx * np.float32(s), ny * np.float32(s), raster, place)
        survival = minimum(survival, 2.0 * q)
        survival = select(survival < ENDED, 0.0, survival)
        total = total + survival * q
        if not any_lane(survival > 0.0):
            break
    return total


@inlined
def ink_at(ink: Array, block: Block, dx: Floats, dy: Floats, raster: Raster, place: Int32) -> Floats:
    """Return bilinear samples of ink at the points (dx, dy) away from a block's pixels; ``place`` is scratch memory."""
    x, u = _pixel_before(dx, block.x, raster.width - 2)
    y, v = _pixel_before(dy, block.y, raster.height - 2)
    store(place, 0, y * raster.stride + x)
    a, b = gather_pairs(ink, place, 0)
    c, d = gather_pairs(ink[raster.stride if raster.height > 1 else 0 :], place, 0)
    upper, lower = a + u * (b - a), c + u * (d - c)
    return upper + v * (lower - upper)


@inlined
def _pixel_before(d: Floats, start: Ints, last: int) -> tuple[Ints, Floats]:
    """Return floor(start + d) clamped to 0 .. ``last``, and the fraction beyond it, 0 to 1.

    As :func:`~flowabs_nodes.sampling.coords.bilinear_coords`, in float32: a stroke is measured by its ink, and so the
    last digits of where it was read do not add up.
    """
    below = floor(d)
    whole = to_ints(below) + start
    after_last = 1.0 if last >= 0 else 0.0  # a picture of one column has nothing to the right of it
    fraction = select(whole < 0, 0.0, select(whole > last, after_last, d - below))
    return maximum(minimum(whole, last), 0), fraction


@kernel
def weigh_widths(
    first: int,
    last: int,
    ink: Array,
    flow: Complex64,
    response: Array,
    raster: Raster,
    rule: Rule,
    middle: Array,
    weighted: Array,
) -> None:
    """Write k in the middle of strokes, else 0, to ``middle``, and w k to ``weighted``: rows ``first`` .. ``last`` - 1.

    Rims go with the middle: walks that begin at a rim would leave the stroke sooner. ``ink`` k, ``flow`` (complex64)
    and the results are (H, stride), flattened. ``response``, of no pixels or as many, multiplies w by min(1, -H /
    strength).
    """
    columns, place = np.empty(raster.stride + LANES, np.int32), scratch(np.int32, 1)
    lanes = np.empty(2 * LANES, np.float32)
    for y in range(first, last):
        row = y * raster.stride
        middle[row : row + raster.stride] = 0
        weighted[row : row + raster.stride] = 0
        found, count = ink_columns(ink, y, FAINT, raster, columns), 0
        for k in range(0, found, LANES):
            one, other = measure_across(ink, flow, Block(load(columns, k), splat_ints(y)), rule.reach, raster, place)
            store(lanes, 0, absolute(one - other))  # 2 |d|
            store(lanes, LANES, one + other)
            for lane in range(min(LANES, found - k)):
                x = columns[k + lane]
                if lanes[lane] <= max(_MIDDLE * (lanes[LANES + lane] + ink[row + x]), _MIDDLE_PIXELS):
                    columns[count] = x
                    count += 1
        fill_block(columns, count)
        for k in range(0, count, LANES):
            block = Block(load(columns, k), splat_ints(y))
            store(lanes, 0, _width(*_both_ways(ink, flow, block, raster, rule, place), rule))
            for lane in range(min(LANES, count - k)):
                at = row + columns[k + lane]
                width = lanes[lane]
                if response.size > 0:
                    width *= min(max(-response[at] / rule.strength, 0), 1)
                middle[at] = ink[at]
                weighted[at] = width * ink[at]


@inlined
def _both_ways(ink: Array, flow: Complex64, block: Block, raster: Raster, rule: Rule, place: Int32) -> Any:
    """Return e and e' of a block's pixels. The second walk ends where no more ink would change a width."""
    store(place, 0, block.y * raster.stride + block.x)
    tx, ty = gather_pairs(flow, place, 0)
    nothing = splat_floats(0.0)
    one = _walk(ink, flow, block, tx, ty, nothing, splat_floats(np.inf), raster, rule, place)
    enough = maximum(LONGEST * rule.min_length - 1.0 - one, rule.taper)
    return one, _walk(ink, flow, block, -tx, -ty, nothing, enough, raster, rule, place)


@inlined
def _walk(
    ink: Array,
    flow: Complex64,
    block: Block,
    tx: Floats,
    ty: Floats,
    total: Floats,
    enough: Floats,
    raster: Raster,
    rule: Rule,
    place: Int32,
) -> Floats:
    """Return e, how much ink of its stroke lies one way of each pixel, or any number from ``enough`` on if it is more.

    The tangents (tx, ty) say which way; ``total`` is 0.
    """
    dx, dy, survival = splat_floats(0.0), splat_floats(0.0), splat_floats(1.0)
    for _ in range(rule.steps):
        dx, dy = dx + tx, dy + ty
        ahead = ink_at(ink, block, dx + ty, dy - tx, raster, place)
        behind = ink_at(ink, block, dx - ty, dy + tx, raster, place)
        aside = (ahead - behind) * 0.5
        dx, dy = dx + aside * ty, dy - aside * tx
        q = minimum(2.0 * ink_at(ink, block, dx, dy, raster, place), 1.0)
        survival = survival * (1.0 - rule.fade * (1.0 - q))
        survival = select(survival < ENDED, 0.0, survival)
        total = total + survival * q
        if not any_lane(select(total < enough, survival, 0.0) > 0.0):
            break
        x = minimum(maximum(to_ints(rint(dx)) + block.x, 0), raster.width - 1)
        y = minimum(maximum(to_ints(rint(dy)) + block.y, 0), raster.height - 1)
        store(place, 0, y * raster.stride + x)
        u, v = gather_pairs(flow, place, 0)
        against = u * tx < -(v * ty)
        tx, ty = select(against, -u, u), select(against, -v, v)
    return total


@inlined
def _width(one_way: Floats, other_way: Floats, rule: Rule) -> Floats:
    """Return w, 0 to 1, of strokes of these lengths both ways."""
    width = splat_floats(1.0)
    if rule.min_length > 0:
        length = (one_way + other_way + 1.0) / rule.min_length
        t = minimum(maximum((length - SHORTEST) / (LONGEST - SHORTEST), 0.0), 1.0)
        width = t * t * (3.0 - 2.0 * t)
    if rule.taper > 0:
        u = minimum((minimum(one_way, other_way) + 0.5) / rule.taper, 1.0)
        width = width * (u * (2.0 - u))
    return width
