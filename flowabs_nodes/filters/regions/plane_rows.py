"""Pictures as rows of planes, which the bilateral filters along x and y read sixteen neighbours at a time from.

The planes of a row are L, a, b of its pixels, and alpha where there is one, each with a margin on both sides that
repeats the border, one after the other. All rows together are one 1-D array. The argument ``alpha`` of a compiled
kernel is True for four planes and None for three (:mod:`~flowabs_nodes.filters.regions.range_weights`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters.regions.range_weights import Sums
from flowabs_nodes.sampling.samples import Color
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.border import repeat_left, repeat_right
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, select, splat_floats
from flowabs_nodes.simd.memory import load, load_triples, store, store_triples
from flowabs_nodes.simd.premultiplied import TINY


class Planes(NamedTuple):
    """The layout of a picture as rows of planes: of ``stride`` pixels per row, the first ``width`` are its own."""

    height: int
    width: int
    stride: int
    margin: int  # pixels to each side of a plane
    channels: int  # planes of a row, three or four


def as_plane_rows(codes: Array, alpha: Array | None, margin: int) -> tuple[Array, Planes]:
    """Return code values (H, W, 3) as rows of planes with a ``margin`` of so many pixels, and their layout.

    ``alpha`` is (H, W), or None. Where it is 0, or too small to divide by, all four planes are 0.
    """
    height, width, _ = codes.shape
    codes, covered = _widened(codes), None if alpha is None else _widened(alpha).reshape(-1)
    planes = Planes(height, width, codes.shape[1], margin, 3 if alpha is None else 4)
    picture = np.empty(height * planes.channels * (planes.stride + 2 * margin), np.float32)
    over_rows(_to_planes, height, codes.reshape(-1), covered, planes, picture)
    return picture, planes


def as_codes(picture: Array, planes: Planes, codes: Array) -> Array:
    """Return rows of planes as code values (H, W, 3); where their alpha is 0, those of ``codes``, (H, W, 3)."""
    wide = _widened(codes)
    result = np.empty_like(wide)
    alpha = True if planes.channels == 4 else None
    over_rows(_from_planes, planes.height, picture, wide.reshape(-1), planes, alpha, result.reshape(-1))
    return np.ascontiguousarray(result[:, : planes.width])


def _widened(image: Array) -> Array:
    """Return (H, W) or (H, W, C) with rows of sixteen pixels at least, the last one repeated, as kernels need them."""
    beyond = max(LANES - image.shape[1], 0)
    return np.pad(image, ((0, 0), (0, beyond), (0, 0))[: image.ndim], "edge") if beyond else image


@inlined
def row_of(y: int, planes: Planes) -> tuple[int, int]:
    """Return the index of the first pixel of row y in its first plane, and the distance from plane to plane."""
    plane = planes.stride + 2 * planes.margin
    return planes.channels * y * plane + planes.margin, plane


@kernel
def _to_planes(first: int, last: int, codes: Array, alpha: Array | None, planes: Planes, picture: Array) -> None:
    """Write rows ``first`` .. ``last`` - 1 as planes; pixels whose alpha is 0 or too small to divide by become 0.

    ``codes`` is (H, stride, 3) and ``alpha``, if there is one, (H, stride), both flattened.
    """
    nothing = splat_floats(0.0)
    for y in range(first, last):
        row, plane = row_of(y, planes)
        for x0 in range(0, planes.stride, LANES):
            x = min(x0, planes.stride - LANES)
            i = y * planes.stride + x
            l0, a0, b0 = load_triples(codes, 3 * i)
            if alpha is not None:
                k = load(alpha, i)
                there = k > TINY
                l0, a0, b0 = select(there, l0, nothing), select(there, a0, nothing), select(there, b0, nothing)
                store(picture, row + 3 * plane + x, select(there, k, nothing))
            store(picture, row + x, l0)
            store(picture, row + plane + x, a0)
            store(picture, row + 2 * plane + x, b0)
        repeat_borders(picture, y, planes)


@inlined
def repeat_borders(picture: Array, y: int, planes: Planes) -> None:
    """Fill the margins of the planes of row y with the pixels at the border."""
    row, plane = row_of(y, planes)
    for c in range(planes.channels):
        repeat_left(picture, row + c * plane, planes.margin, 1)
        repeat_right(picture, row + c * plane + planes.width, planes.margin, 1)


@kernel
def _from_planes(
    first: int, last: int, picture: Array, codes: Array, planes: Planes, alpha: bool | None, result: Array
) -> None:
    """Write the colours of rows ``first`` .. ``last`` - 1 to ``result``; where alpha is 0, those of ``codes``.

    ``codes`` and ``result`` are (H, stride, 3), flattened.
    """
    for y in range(first, last):
        row, plane = row_of(y, planes)
        for x0 in range(0, planes.stride, LANES):
            x = min(x0, planes.stride - LANES)
            i = 3 * (y * planes.stride + x)
            colour = load_color(picture, row + x, plane, alpha)
            l0, a0, b0 = colour.l, colour.a, colour.b
            if alpha is not None:
                there, given = colour.alpha > 0.0, load_triples(codes, i)
                l0, a0, b0 = select(there, l0, given[0]), select(there, a0, given[1]), select(there, b0, given[2])
            store_triples(result, i, (l0, a0, b0))


@inlined
def load_color(picture: Array, i: int, plane: int, alpha: bool | None) -> Color:
    """Return sixteen pixels, of which the first is at ``i`` in its first plane."""
    covered = splat_floats(1.0) if alpha is None else load(picture, i + 3 * plane)
    return Color(load(picture, i), load(picture, i + plane), load(picture, i + 2 * plane), covered)


@inlined
def store_mean(sums: Sums, centre: Color, smoothed: Array, i: int, plane: int, alpha: bool | None) -> None:
    """Write the weighted means of sixteen pixels from ``i`` on; where alpha is 0 the colour stays the centre's."""
    over = 1.0 / sums.weight
    if alpha is not None:
        over = select(centre.alpha > 0.0, over, 0.0)
        store(smoothed, i + 3 * plane, centre.alpha)
    store(smoothed, i, centre.l + over * sums.l)
    store(smoothed, i + plane, centre.a + over * sums.a)
    store(smoothed, i + 2 * plane, centre.b + over * sums.b)
