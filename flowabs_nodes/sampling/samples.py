"""Readings of a picture of records at points near each of sixteen pixels: at the nearest pixel, or bilinearly.

Where to read is written down for many samples (:class:`SampleCoords`) before the first is taken, so that they need
not wait for each other. ``bilinear`` is None or not, by which numba leaves out what does not happen.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from flowabs_nodes.sampling.coords import Raster, bilinear_coords, nearest_pixels
from flowabs_nodes.simd.jit import inline, inlined
from flowabs_nodes.simd.lanes import LANES, select
from flowabs_nodes.simd.memory import gather_octets, gather_quads, load, prefetch, prefetch_for_write, scratch, store

TINY = np.float32(1e-20)  # an alpha from which colours can no longer be told
PREFETCH_AHEAD = 128  # pixels: what is fetched while these are worked on


class Color(NamedTuple):
    """Of sixteen records. What is read of records of three has no alpha: what is there then means nothing."""

    l: Any  # noqa: E741
    a: Any
    b: Any
    alpha: Any


class SampleCoords(NamedTuple):
    """Of up to 64 readings, where the record is, and how far beyond its pixel the point."""

    place: Any
    fx: Any
    fy: Any


@inline
def new_sample_coords() -> SampleCoords:
    return SampleCoords(scratch(np.int32, 64), scratch(np.float32, 64), scratch(np.float32, 64))


@inlined
def row_below(raster: Raster, size: int) -> int:
    """From a record to the one below, if there is one."""
    return size * raster.stride if raster.height > 1 else 0


@inlined
def prefetch_rows(picture: Any, smoothed: Any, x: int, y: int, below: int, raster: Raster, size: int) -> None:
    """Have fetched what is needed before long; ``below``: the first row that is not yet."""
    for k in range(0, LANES * size, LANES):
        prefetch(picture, size * (min(y + below, raster.height - 1) * raster.stride + x) + k)
        prefetch_for_write(smoothed, size * (y * raster.stride + x + PREFETCH_AHEAD) + k)


@inlined
def locate(
    coords: SampleCoords, at: int, dx: Any, dy: Any, x: int, y: int, raster: Raster, size: int, bilinear: Any
) -> None:
    """The reading at [at] is to be taken (dx, dy) from the pixels x .. x + 15 of row y."""
    if bilinear is None:
        columns, rows = nearest_pixels(dx, dy, x, y, raster)
        store(coords.place, at, (rows * raster.stride + columns) * size)
    else:
        corner = bilinear_coords(dx, dy, x, y, raster)
        store(coords.place, at, (corner.y * raster.stride + corner.x) * size)
        store(coords.fx, at, corner.fx)
        store(coords.fy, at, corner.fy)


@inlined
def sample(picture: Any, below: int, coords: SampleCoords, at: int, bilinear: Any, alpha: Any) -> Color:
    """Bilinearly, colours count by how much is there of each. ``below`` is :func:`row_below`."""
    if bilinear is None:
        l, a, b, covered = gather_quads(picture, coords.place, at)  # noqa: E741
        return Color(l, a, b, covered)
    u, v = load(coords.fx, at), load(coords.fy, at)
    upper, lower = _sample_across(picture, coords, at, u, alpha), _sample_across(picture[below:], coords, at, u, alpha)
    l, a, b = _mix(upper.l, lower.l, v), _mix(upper.a, lower.a, v), _mix(upper.b, lower.b, v)  # noqa: E741
    if alpha is None:
        return Color(l, a, b, upper.alpha)
    covered = _mix(upper.alpha, lower.alpha, v)
    over = select(covered > TINY, 1.0 / covered, 0.0)
    return Color(over * l, over * a, over * b, covered)


@inlined
def _sample_across(picture: Any, coords: SampleCoords, at: int, u: Any, alpha: Any) -> Color:
    """Between a pixel and the one to the right; colours times alpha."""
    l, a, b, c, d, e, f, g = gather_octets(picture, coords.place, at)  # noqa: E741
    if alpha is None:
        return Color(_mix(l, c, u), _mix(a, d, u), _mix(b, e, u), f)
    return Color(_mix(c * l, g * d, u), _mix(c * a, g * e, u), _mix(c * b, g * f, u), _mix(c, g, u))


@inlined
def _mix(one: Any, other: Any, share: Any) -> Any:
    return one + share * (other - one)
