"""Samples of a picture at points near each of sixteen pixels: of the nearest pixel, or bilinear.

The picture is one of records, flattened: three floats (L, a, b) for each pixel, or four (L, a, b, alpha), colours not
premultiplied. Its rows have the raster's stride. ``size`` is the number of floats in a record.

Kernels compute the coordinates of many samples (:class:`SampleCoords`) before they read the first, so that the reads
need not wait for each other. The flags ``bilinear`` and ``alpha`` are None or True rather than False or True: numba
compiles a kernel for each combination, without the branches not taken.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array, Int32
from flowabs_nodes.sampling.coords import Raster, bilinear_coords, clamped_columns, clamped_rows, nearest_pixels
from flowabs_nodes.simd.jit import inline, inlined
from flowabs_nodes.simd.lanes import LANES, Doubles, Floats, lane_indices, round_to_ints, select, splat_ints
from flowabs_nodes.simd.memory import gather_octets, gather_quads, load, prefetch, prefetch_for_write, scratch, store
from flowabs_nodes.simd.premultiplied import TINY

#: How many pixels ahead of the pixel at work memory is fetched.
PREFETCH_AHEAD = 128


class Color(NamedTuple):
    """Sixteen records. Records of three floats have no alpha; ``alpha`` then holds a number without a meaning."""

    l: Floats  # noqa: E741
    a: Floats
    b: Floats
    alpha: Floats


class SampleCoords(NamedTuple):
    """The coordinates of up to 64 samples of sixteen pixels, in scratch memory.

    Bilinear samples use all fields, samples of the nearest pixel ``place`` alone.
    """

    place: Int32  # index in the picture of the record of the nearest pixel, or of the upper left of the four
    fx: Array  # distance of the point from the upper left pixel, to the right and down, 0 to 1
    fy: Array


@inline
def new_sample_coords() -> SampleCoords:
    """Return uninitialised sample coordinates on the kernel's stack."""
    return SampleCoords(scratch(np.int32, 64), scratch(np.float32, 64), scratch(np.float32, 64))


@inlined
def row_below(raster: Raster, size: int) -> int:
    """Return the distance in floats from a record to the one below; 0 in a picture of one row."""
    return size * raster.stride if raster.height > 1 else 0


@inlined
def prefetch_rows(picture: Array, smoothed: Array, x: int, y: int, below: int, raster: Raster, size: int) -> None:
    """Ask for the memory that a kernel needs soon, while it is at the pixels x .. x + 15 of row y.

    Of ``picture``, that is the same columns ``below`` rows further down, the first row not yet in the cache; of
    ``smoothed``, the result, pixels of the same row further right.
    """
    for k in range(0, LANES * size, LANES):
        prefetch(picture, size * (min(y + below, raster.height - 1) * raster.stride + x) + k)
        prefetch_for_write(smoothed, size * (y * raster.stride + x + PREFETCH_AHEAD) + k)


@inlined
def locate(
    coords: SampleCoords,
    at: int,
    offset: tuple[Doubles, Doubles],
    x: int,
    y: int,
    raster: Raster,
    size: int,
    bilinear: bool | None,
) -> None:
    """Write the coordinates of the samples ``offset`` (dx, dy) away from the pixels x .. x + 15 of row y.

    ``coords`` takes them from index ``at`` on, a multiple of sixteen. ``raster`` and ``size`` are those of the picture
    and of its records, ``bilinear`` is None or True.
    """
    dx, dy = offset
    if bilinear is None:
        columns, rows = nearest_pixels(dx, dy, x, y, raster)
        store(coords.place, at, (rows * raster.stride + columns) * size)
    else:
        corner = bilinear_coords(dx, dy, x, y, raster)
        store(coords.place, at, (corner.y * raster.stride + corner.x) * size)
        store(coords.fx, at, corner.fx)
        store(coords.fy, at, corner.fy)


@inlined
def locate_both_sides(
    coords: SampleCoords, at: int, offset: tuple[Doubles, Doubles], x: int, y: int, raster: Raster, size: int
) -> None:
    """Write where the nearest pixels to the points ``offset`` away are, and after them those to the opposite points."""
    columns, rows = round_to_ints(offset[0]), round_to_ints(offset[1])  # of the opposite point they are the negative
    column, row = lane_indices() + x, splat_ints(y)
    place = clamped_rows(row + rows, raster) * raster.stride + clamped_columns(column + columns, raster)
    other = clamped_rows(row - rows, raster) * raster.stride + clamped_columns(column - columns, raster)
    store(coords.place, at, place * size)
    store(coords.place, at + LANES, other * size)


@inlined
def sample(
    picture: Array, below: int, coords: SampleCoords, at: int, bilinear: bool | None, alpha: bool | None
) -> Color:
    """Return the samples of ``picture`` at the coordinates from index ``at`` on; ``below`` is :func:`row_below`.

    In a bilinear sample with ``alpha``, each of the four colours counts in proportion to its alpha.
    """
    if bilinear is None:
        l, a, b, covered = gather_quads(picture, coords.place, at)  # noqa: E741
        return Color(l, a, b, covered)
    u, v = load(coords.fx, at), load(coords.fy, at)
    upper, lower = _sample_across(picture, coords, at, u, alpha), _sample_across(picture[below:], coords, at, u, alpha)
    l, a, b = _mix(upper.l, lower.l, v), _mix(upper.a, lower.a, v), _mix(upper.b, lower.b, v)  # noqa: E741
    if alpha is None:
        return Color(l, a, b, upper.alpha)
    covered = _mix(upper.alpha, lower.alpha, v)
    inverse = select(covered > TINY, 1.0 / covered, 0.0)
    return Color(inverse * l, inverse * a, inverse * b, covered)


@inlined
def _sample_across(picture: Array, coords: SampleCoords, at: int, u: Floats, alpha: bool | None) -> Color:
    """Return the mixture of each pixel and ``u`` of the one to its right, with ``alpha`` of premultiplied colours."""
    l, a, b, c, d, e, f, g = gather_octets(picture, coords.place, at)  # noqa: E741
    if alpha is None:
        return Color(_mix(l, c, u), _mix(a, d, u), _mix(b, e, u), f)
    return Color(_mix(c * l, g * d, u), _mix(c * a, g * e, u), _mix(c * b, g * f, u), _mix(c, g, u))


@inlined
def _mix(one: Floats, other: Floats, share: Floats) -> Floats:
    """Return the linear interpolation from ``one``, at share 0, to ``other``, at share 1."""
    return one + share * (other - one)
