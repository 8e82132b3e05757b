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

from flowabs_nodes.array_types import Array, Int32
from flowabs_nodes.filters.motion.places import (
    Pairs,
    Path,
    Place,
    corner_pairs,
    mix4,
    place_of,
    sample_plane,
    set_place,
)
from flowabs_nodes.sampling.coords import Raster
from flowabs_nodes.simd.elementary import exp2_of_negative
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import (
    LANES,
    Floats,
    Masks,
    absolute,
    maximum,
    minimum,
    select,
    splat_floats,
    sqrt,
)
from flowabs_nodes.simd.memory import gather_quads, load, load_pairs, load_quads, store

#: Where the steps of the four pixels around a place differ by more than this, in pixels, the nearest one's is taken.
APART = 1.5


class Seen(NamedTuple):
    """What there is to compare on a frame; of no pixels where it is not given.

    ``guide`` is (H x stride,), ``surface`` (H x stride x 4,): a normal, then the depth.
    """

    guide: Array
    surface: Array


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
    for y in range(first, last):
        for x0 in range(0, raster.stride, LANES):
            x = min(x0, raster.stride - LANES)
            dx, dy = load_pairs(steps, y * raster.stride + x)
            set_place(after, (y - first) * raster.stride + x, dx, dy, x, y, raster)


@kernel
def go_on(first: int, last: int, raster: Raster, steps: Pairs, before: Path, after: Path) -> None:
    """Lead the pixels of the rows ``first`` .. ``last`` - 1 one frame further: from ``before``, write ``after``.

    ``steps`` are those of the frame that the paths have come to, towards the next one.
    """
    for y in range(first, last):
        for x0 in range(0, raster.stride, LANES):
            x = min(x0, raster.stride - LANES)
            at = (y - first) * raster.stride + x
            step_x, step_y = _step_from(steps, place_of(before, at, raster))
            dx, dy = load(before.dx, at) + step_x, load(before.dy, at) + step_y
            set_place(after, at, dx, dy, x, y, raster)


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
    records = np.empty(stride, np.int32)  # where the surfaces of places' upper left pixels stand
    for y in range(first, last):
        begin = (y - first) * stride
        if own.surface.size > 0:
            for x0 in range(0, stride, LANES):
                x = min(x0, stride - LANES)
                store(records, x, 4 * load(after.corner, begin + x))
        for x0 in range(0, stride, LANES):
            x = min(x0, stride - LANES)
            pixel, at = y * stride + x, begin + x
            place, dx, dy = place_of(after, at, raster), load(after.dx, at), load(after.dy, at)
            back_x, back_y = _step_from(back, place)
            miss_x, miss_y = dx + back_x - load(before.dx, at), dy + back_y - load(before.dy, at)
            found = miss_x * miss_x + miss_y * miss_y <= limits.consistency * limits.consistency  # NaN is not
            if own.surface.size > 0:
                found = found & _same_surface(own.surface, there.surface, records, x, pixel, limits, raster)
            weight = splat_floats(limits.falloff)
            if own.guide.size > 0:
                change = sample_plane(there.guide, place) - load(own.guide, pixel)
                weight = weight * exp2_of_negative(limits.exponent * change * change)
            store(after.dx, at, select(found, dx, splat_floats(np.float32(np.nan))))
            store(after.weight, at, select(found, weight, splat_floats(0.0)))


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


@inlined
def _same_surface(own: Array, there: Array, corner: Int32, x: int, pixel: int, limits: Limits, raster: Raster) -> Masks:
    """Return where one of the four pixels around a place has the pixel's depth and normal; (0, 0, 0) goes with any.

    ``corner`` is, from x on, where the record of the upper left one stands.
    """
    u, v, w, z = load_quads(own, 4 * pixel)
    square = u * u + v * v + w * w
    found = z > z  # nowhere
    for k in range(4):
        right, below = min(k % 2, raster.width - 1), min(k // 2, raster.height - 1)
        a, b, c, z_there = gather_quads(there[4 * (below * raster.stride + right) :], corner, x)
        as_far = absolute(z_there - z) <= limits.depth * minimum(absolute(z), absolute(z_there))
        alike = u * a + v * b + w * c >= limits.cosine * sqrt(square * (a * a + b * b + c * c))
        found = found | (as_far & alike)
    return found
