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
from typing import NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array, Complex64, Int32
from flowabs_nodes.filters.lines.stroke_lengths import LONGEST, SHORTEST, gap, longest_walk
from flowabs_nodes.sampling.coords import Raster, bilinear_coords, nearest_pixels
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import (
    LANES,
    Doubles,
    Floats,
    Ints,
    any_lane,
    lane_indices,
    maximum,
    minimum,
    select,
    splat_doubles,
    splat_floats,
    splat_ints,
    to_doubles,
)
from flowabs_nodes.simd.memory import gather_pairs, load, scratch, store

#: The share of a stroke below which it has ended.
ENDED = np.float32(1 / 64)

#: Ink below this is no stroke of its own: it goes with the strokes around it, and is paper where a stroke is measured.
FAINT = np.float32(1 / 64)


class Rule(NamedTuple):
    """What makes a stroke: lengths in pixels, 0 for what does not count."""

    min_length: np.float32
    taper: np.float32
    fade: np.float32  # lambda
    steps: int  # the longest walk
    strength: np.float32  # response at which a stroke has its full width

    @classmethod
    def of(cls, min_length: float, taper: float, strength: float) -> Rule:
        """Return the rule for lengths in pixels and a response in code values."""
        length = gap(min_length, taper)
        fade = 1 - math.exp(-1 / length) if length > 0 else 1.0
        steps = longest_walk(min_length, taper)
        return cls(np.float32(min_length), np.float32(taper), np.float32(fade), steps, np.float32(strength))


class Block(NamedTuple):
    """Sixteen pixels anywhere in a row."""

    x: Ints  # the column of each, less its lane
    y: Ints


@inlined
def ink_columns(ink: Array, y: int, raster: Raster, columns: Int32) -> int:
    """Write the columns of row y that have ink to ``columns``, the last one again up to a whole block; count them."""
    count = 0
    for x in range(raster.width):
        if ink[y * raster.stride + x] > 0:
            columns[count] = x
            count += 1
    for k in range(count, count + (-count) % LANES):
        columns[k] = columns[count - 1]
    return count


@inlined
def block_at(columns: Int32, k: int, y: int) -> Block:
    """Return the sixteen pixels of row y in columns[k .. k + 15]."""
    return Block(load(columns, k) - lane_indices(), splat_ints(y))


@inlined
def ink_at(ink: Array, block: Block, dx: Doubles, dy: Doubles, place: Int32, raster: Raster) -> Floats:
    """Return bilinear samples of ink at the points (dx, dy) away from a block's pixels; ``place`` is scratch memory."""
    corner = bilinear_coords(dx, dy, block.x, block.y, raster)
    store(place, 0, corner.y * raster.stride + corner.x)
    a, b = gather_pairs(ink, place, 0)
    c, d = gather_pairs(ink[raster.stride if raster.height > 1 else 0 :], place, 0)
    upper, lower = a + corner.fx * (b - a), c + corner.fx * (d - c)
    return upper + corner.fy * (lower - upper)


@kernel
def weigh_widths(
    first: int, last: int, ink: Array, flow: Complex64, response: Array, raster: Raster, rule: Rule, weighted: Array
) -> None:
    """Write w k for the rows ``first`` .. ``last`` - 1: the width of a pixel's stroke, weighted by its ink.

    ``ink`` k, ``flow`` (complex64) and ``weighted`` are (H, stride), flattened. ``response``, of no pixels or as many,
    multiplies w by min(1, -H / strength).
    """
    columns, place = np.empty(raster.stride + LANES, np.int32), scratch(np.int32, 1)
    widths = np.empty(LANES, np.float32)
    for y in range(first, last):
        row = y * raster.stride
        weighted[row : row + raster.stride] = 0
        count = ink_columns(ink, y, raster, columns)
        for k in range(0, count, LANES):
            block = block_at(columns, k, y)
            store(place, 0, block.x + lane_indices() + row)
            tx, ty = gather_pairs(flow, place, 0)
            nothing = splat_floats(0.0)
            one_way = _walk(ink, flow, block, tx, ty, nothing, splat_floats(np.inf), place, raster, rule)
            enough = maximum(LONGEST * rule.min_length - 1.0 - one_way, rule.taper)
            other_way = _walk(ink, flow, block, -tx, -ty, nothing, enough, place, raster, rule)
            store(widths, 0, _width(one_way, other_way, rule))
            for lane in range(min(LANES, count - k)):
                at = row + columns[k + lane]
                width = widths[lane]
                if response.size > 0:
                    width *= min(max(-response[at] / rule.strength, 0), 1)
                weighted[at] = width * ink[at]


@inlined
def _walk(
    ink: Array,
    flow: Complex64,
    block: Block,
    tx: Floats,
    ty: Floats,
    total: Floats,
    enough: Floats,
    place: Int32,
    raster: Raster,
    rule: Rule,
) -> Floats:
    """Return e, how much ink of its stroke lies one way of each pixel, or any number from ``enough`` on if it is more.

    The tangents (tx, ty) say which way; ``total`` is 0.
    """
    dx, dy, survival = splat_doubles(0.0), splat_doubles(0.0), splat_floats(1.0)
    for _ in range(rule.steps):
        dx, dy = dx + to_doubles(tx), dy + to_doubles(ty)
        nx, ny = to_doubles(ty), to_doubles(-tx)
        ahead = ink_at(ink, block, dx + nx, dy + ny, place, raster)
        behind = ink_at(ink, block, dx - nx, dy - ny, place, raster)
        aside = to_doubles((ahead - behind) * 0.5)
        dx, dy = dx + aside * nx, dy + aside * ny
        q = minimum(2.0 * ink_at(ink, block, dx, dy, place, raster), 1.0)
        survival = survival * (1.0 - rule.fade * (1.0 - q))
        survival = select(survival < ENDED, 0.0, survival)
        total = total + survival * q
        if not any_lane(select(total < enough, survival, 0.0) > 0.0):
            break
        column, line = nearest_pixels(dx, dy, block.x, block.y, raster)
        store(place, 0, line * raster.stride + column)
        x, y = gather_pairs(flow, place, 0)
        against = x * tx < -(y * ty)
        tx, ty = select(against, -x, x), select(against, -y, y)
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
