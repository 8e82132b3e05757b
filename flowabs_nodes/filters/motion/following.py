"""Following each pixel's surface one frame further, and what its place there is worth.

A path is kept as the way from a pixel to its place on the frame that it has come to: offsets x right, y down, NaN once
it is lost. It is lost where it

- leaves the picture;
- does not come back: the step back from the new place misses the old one by more than ``consistency`` pixels;
- comes to where none of the four pixels around is of its surface: their depths differ from the pixel's own by more than
  ``depth_tolerance`` of the nearer one, for each frame of the way, or their normals are turned by more than
  ``normal_tolerance``. Something else is in front.

The weight of a place on frame k is

    g(k) exp(-(L_k - L_0)^2 / (2 agreement^2))

with L the guide. Where light has changed, a shadow or a highlight gone by, the frames do not agree, and are not mixed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters.motion.places import (
    Pairs,
    Path,
    Place,
    addresses,
    corner_pairs,
    mix4,
    place_of,
    sample_plane,
    set_place,
)
from flowabs_nodes.filters.motion.surface import same_depth, same_normal
from flowabs_nodes.sampling.coords import Raster
from flowabs_nodes.simd.elementary import exp2_of_negative
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import (
    LANES,
    Floats,
    maximum,
    minimum,
    select,
    splat_floats,
)
from flowabs_nodes.simd.memory import address, keep, load, load_pairs, store

#: Where the steps of the four pixels around a place differ by more than this, in pixels, the nearest one's is taken.
APART = 1.5


class Seen(NamedTuple):
    """What there is to compare on a frame, flattened; of no pixels where it is not given."""

    guide: Array
    depth: Array
    normal: Array  # as :func:`~.places.rows_of_triples` gives it


class Limits(NamedTuple):
    """What is asked of a place on a frame."""

    consistency: float  # largest miss, in pixels
    depth: float  # largest difference, of the nearer depth
    cosine: float  # least cosine between the normals
    exponent: float  # the agreement's: its weight is 2^(exponent (L_k - L_0)^2)
    falloff: float  # g(k)


@kernel
def set_out(first: int, last: int, raster: Raster, steps: Pairs, after: Path) -> None:
    """Lead the pixels of the rows ``first`` .. ``last`` - 1 from their own frame to the next one: write ``after``."""
    there = addresses(after)
    for y in range(first, last):
        for x0 in range(0, raster.stride, LANES):
            x = min(x0, raster.stride - LANES)
            dx, dy = load_pairs(steps, y * raster.stride + x)
            set_place(there, (y - first) * raster.stride + x, dx, dy, x, y, raster)


@kernel
def go_on(first: int, last: int, raster: Raster, steps: Pairs, before: Path, after: Path) -> None:
    """Lead the pixels of the rows ``first`` .. ``last`` - 1 one frame further: from ``before``, write ``after``.

    ``steps`` are those of the frame that the paths have come to, towards the next one.
    """
    here, there, onward = addresses(before), addresses(after), address(steps, 0)
    for y in range(first, last):
        for x0 in range(0, raster.stride, LANES):
            x = min(x0, raster.stride - LANES)
            at = (y - first) * raster.stride + x
            step_x, step_y = _step_from(onward, place_of(here, at, raster))
            dx, dy = load(here.dx, at) + step_x, load(here.dy, at) + step_y
            set_place(there, at, dx, dy, x, y, raster)


@kernel
def judge(
    first: int,
    last: int,
    raster: Raster,
    back: Pairs,
    own: Seen,
    there: Seen,
    limits: Limits,
    before: Path,
    after: Path,
) -> None:
    """Give the places of ``after`` their weights, for the pixels of the rows ``first`` .. ``last`` - 1; lose some.

    ``back`` are the steps of their frame to the one of ``before``. ``own`` is what is seen on the pixels' own frame,
    ``there`` what is seen on that of the places.
    """
    stride = raster.stride
    before, after, back = addresses(before), addresses(after), address(back, 0)
    has_guide, has_depth, has_normal = own.guide.size > 0, own.depth.size > 0, own.normal.size > 0
    guide, depth, normal = address(own.guide, 0), address(own.depth, 0), address(own.normal, 0)
    guide_there, depth_there, normal_there = address(there.guide, 0), address(there.depth, 0), address(there.normal, 0)
    row = np.empty(stride, np.int32)
    records = address(row, 0)  # where the normals of places' upper left pixels stand
    for y in range(first, last):
        begin = (y - first) * stride
        if has_normal:
            for x0 in range(0, stride, LANES):
                x = min(x0, stride - LANES)
                store(records, x, 3 * load(after.corner, begin + x))
        for x0 in range(0, stride, LANES):
            x = min(x0, stride - LANES)
            pixel, at = y * stride + x, begin + x
            place, dx, dy = place_of(after, at, raster), load(after.dx, at), load(after.dy, at)
            back_x, back_y = _step_from(back, place)
            miss_x, miss_y = dx + back_x - load(before.dx, at), dy + back_y - load(before.dy, at)
            found = miss_x * miss_x + miss_y * miss_y <= limits.consistency * limits.consistency  # NaN is not
            if has_depth or has_normal:
                a = b = c = d = found
                if has_depth:
                    a, b, c, d = same_depth(depth, depth_there, pixel, place, limits.depth)
                if has_normal:
                    e, f, g, h = same_normal(normal, normal_there, pixel, records, x, limits.cosine, raster)
                    a, b, c, d = a & e, b & f, c & g, d & h
                found = found & (a | b | c | d)
            weight = splat_floats(limits.falloff)
            if has_guide:
                change = sample_plane(guide_there, place) - load(guide, pixel)
                weight = weight * exp2_of_negative(limits.exponent * change * change)
            store(after.dx, at, select(found, dx, splat_floats(np.float32(np.nan))))
            store(after.weight, at, select(found, weight, splat_floats(0.0)))
    keep(row)


@inlined
def _step_from(steps: Pairs, at: Place) -> tuple[Floats, Floats]:
    """Return the steps at the places: bilinear where the four pixels around move alike, else the nearest one's."""
    ax, ay, bx, by, cx, cy, dx, dy = corner_pairs(steps, at)
    spread_x = maximum(maximum(ax, bx), maximum(cx, dx)) - minimum(minimum(ax, bx), minimum(cx, dx))
    spread_y = maximum(maximum(ay, by), maximum(cy, dy)) - minimum(minimum(ay, by), minimum(cy, dy))
    total = (ax + bx + cx + dx) + (ay + by + cy + dy)
    alike = (spread_x <= APART) & (spread_y <= APART) & (total - total == 0.0)  # spreads do not see every NaN
    right, lower = at.fx >= 0.5, at.fy >= 0.5
    nearest_x = select(lower, select(right, dx, cx), select(right, bx, ax))
    nearest_y = select(lower, select(right, dy, cy), select(right, by, ay))
    return select(alike, mix4(ax, bx, cx, dx, at), nearest_x), select(alike, mix4(ay, by, cy, dy, at), nearest_y)
