"""Reduced pictures, and what is made of them brought back up: by a factor of 2 or 4, on a grid of whole pixels.

Pixel i of a reduced axis is the mean of the pixels ``factor`` i .. ``factor`` i + ``factor`` - 1; where these go on
beyond the picture, its border is repeated. A pixel at full size lies between the centres of reduced pixels, at one of
``factor`` places, its *phase*. The weights of each phase are fractions of powers of two: exact, and their sum is 1.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array, Float64
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.border import repeat_left, repeat_right
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, Doubles, from_doubles, splat_doubles, to_doubles
from flowabs_nodes.simd.memory import load, store, store_pairs, store_quads

#: Reduced pixels that the weights of a phase reach to each side of the one that a pixel lies in.
REACH = 2


def reduced(picture: Array, factor: int, weights: Array | None = None) -> Array:
    """Return the means of blocks of ``factor`` x ``factor`` pixels, (h, w) or (h, w, C) float32.

    Parameters
    ----------
    picture
        (H, W) or (H, W, C) float32. h is H / ``factor``, rounded up, w likewise.
    factor
        1, which gives the picture itself, 2 or 4.
    weights
        What each pixel counts, (H, W), at least 0; None is 1 everywhere. Blocks that count nothing become 0.
    """
    if factor == 1:
        return picture
    height, width = picture.shape[:2]
    small = np.empty((-(-height // factor), -(-width // factor), *picture.shape[2:]), np.float32)
    channels = small[0, 0].size
    blocks = small.reshape(small.shape[0], small.shape[1], channels)
    if weights is None:
        rows = picture.reshape(height, width * channels)
        if rows.shape[1] < LANES:  # what is added never counts
            rows = np.pad(rows, ((0, 0), (0, LANES - rows.shape[1])))
        over_rows(_reduce, small.shape[0], rows, width, factor, blocks)
    else:
        over_rows(_reduce_weighted, small.shape[0], picture.reshape(height, width, channels), weights, factor, blocks)
    return small


@kernel
def _reduce(first: int, last: int, picture: Array, width: int, factor: int, blocks: Array) -> None:
    """Write rows ``first`` .. ``last`` - 1 of the means of blocks, (h, w, C); ``picture`` has rows of W C numbers."""
    (height, stride), (_, across, channels) = picture.shape, blocks.shape
    columns = np.empty(max(stride, factor * across * channels))  # the sums of each column's pixels, border repeated
    for j in range(first, last):
        for x0 in range(0, stride, LANES):
            x, total = min(x0, stride - LANES), splat_doubles(0.0)
            for dy in range(factor):
                total = total + to_doubles(load(picture[min(factor * j + dy, height - 1)], x))
            store(columns, x, total)
        repeat_right(columns, width * channels, factor * across - width, channels)
        means_of_columns(columns, factor, blocks[j])


@inlined
def means_of_columns(columns: Float64, factor: int, means: Any) -> None:
    """Write the means of blocks, (w, C), whose ``columns``, of C numbers each, have been summed."""
    across, channels = means.shape
    for c in range(channels):
        for i in range(across):
            k = factor * i * channels + c
            total = columns[k] + columns[k + channels]
            if factor == 4:
                total += columns[k + 2 * channels] + columns[k + 3 * channels]
            means[i, c] = total / (factor * factor)


@kernel
def _reduce_weighted(first: int, last: int, picture: Array, weights: Array, factor: int, blocks: Array) -> None:
    """Write rows ``first`` .. ``last`` - 1 of the weighted means of blocks, (h, w, C); ``picture`` is (H, W, C)."""
    height, width, channels = picture.shape
    for j in range(first, last):
        for i in range(blocks.shape[1]):
            for c in range(channels):
                total, count = 0.0, 0.0
                for dy in range(factor):
                    y = min(factor * j + dy, height - 1)
                    for dx in range(factor):
                        x = min(factor * i + dx, width - 1)
                        total += np.float64(picture[y, x, c]) * weights[y, x]
                        count += np.float64(weights[y, x])
                blocks[j, i, c] = total / count if count > 0 else 0.0


def reduced_planes(planes: Array, factor: int) -> Array:
    """Return planes (P, H, W) :func:`reduced`, (P, h, w)."""
    return planes if factor == 1 else np.stack([reduced(plane, factor) for plane in planes])


def cubic_phases(factor: int) -> Float64:
    """Return the weights of four neighbours at each phase, (factor, 4), by Catmull-Rom's cubic.

    E. Catmull, R. Rom: "A class of local interpolating splines", 1974; a = -1/2 in R. Keys: "Cubic convolution
    interpolation for digital image processing", 1981.
    """
    t = _distances(factor)
    return np.stack(
        [
            -t / 2 + t**2 - t**3 / 2,
            1 - 5 * t**2 / 2 + 3 * t**3 / 2,
            t / 2 + 2 * t**2 - 3 * t**3 / 2,
            -(t**2) / 2 + t**3 / 2,
        ],
        axis=1,
    )


def linear_phases(factor: int) -> Float64:
    """Return the weights of four neighbours at each phase, (factor, 4), between the two in the middle."""
    t = _distances(factor)
    return np.stack([0 * t, 1 - t, t, 0 * t], axis=1)


def _distances(factor: int) -> Float64:
    """Return how far each phase lies beyond the centre of the reduced pixel before it, 0 to 1."""
    return ((np.arange(factor) + 0.5) / factor - 0.5) % 1.0


class Enlargement(NamedTuple):
    """How reduced planes are brought up, as one argument of a compiled kernel."""

    factor: int
    phases: Float64  # (factor, 4)
    width: int  # of the reduced planes
    stride: int  # of their rows in memory, at least sixteen


def planes_to_enlarge(planes: Array, phases: Float64) -> tuple[Array, Enlargement]:
    """Return reduced planes, (P, h, w), with rows of at least sixteen pixels, and how they are brought up."""
    width = planes.shape[2]
    if width < LANES:
        planes = np.pad(planes, ((0, 0), (0, 0), (0, LANES - width)))
    return np.ascontiguousarray(planes), Enlargement(len(phases), phases, width, planes.shape[2])


def enlarged(planes: Array, factor: int, height: int, width: int, first: int = 0, last: int | None = None) -> Array:
    """Return reduced planes brought up to full size by Catmull-Rom's cubic, (P, height, width) float32.

    ``planes`` are (P, h, w) float32, h and w those of a picture of ``height`` x ``width`` that was :func:`reduced`. Of
    the result there are the rows ``first`` .. ``last`` - 1 alone, where these are given.
    """
    last = height if last is None else last
    if factor == 1:
        return planes[:, first:last]
    result = np.empty((len(planes), last - first, width), np.float32)
    small, how = planes_to_enlarge(planes, cubic_phases(factor))
    for plane, large in zip(small, result, strict=True):
        over_rows(_enlarge, last - first, plane, how, first, large)
    return result


@kernel
def _enlarge(first: int, last: int, plane: Array, how: Enlargement, start: int, large: Array) -> None:
    """Write rows ``first`` .. ``last`` - 1 of ``large``, whose first row is row ``start`` of a plane brought up."""
    column, row = new_column(how), np.empty(how.factor * how.stride, np.float32)
    for y in range(first, last):
        enlarge_row(plane, start + y, how, column, row)
        for x in range(large.shape[1]):
            large[y, x] = row[x]


@inlined
def new_column(how: Enlargement) -> Float64:
    """Return memory for :func:`enlarge_row`."""
    return np.empty(how.stride + 2 * REACH)


@inlined
def enlarge_row(plane: Array, y: int, how: Enlargement, column: Float64, row: Array) -> None:
    """Write row y at full size of a reduced plane (h, stride), into ``row``, which has room for factor x stride."""
    factor, phases, width, stride = how
    height, j, t = plane.shape[0], _before(y, factor), y % factor
    a, b = plane[min(max(j - 1, 0), height - 1)], plane[min(max(j, 0), height - 1)]
    c, d = plane[min(j + 1, height - 1)], plane[min(j + 2, height - 1)]
    for x in range(0, stride, LANES):
        i = min(x, stride - LANES)
        total = phases[t, 0] * to_doubles(load(a, i)) + phases[t, 1] * to_doubles(load(b, i))
        total = total + phases[t, 2] * to_doubles(load(c, i)) + phases[t, 3] * to_doubles(load(d, i))
        store(column, REACH + i, total)
    repeat_left(column, REACH, REACH, 1)
    repeat_right(column, REACH + width, REACH, 1)
    for x in range(0, stride, LANES):
        i = min(x, stride - LANES)
        if factor == 2:
            store_pairs(row, 2 * i, (_at(column, i, 0, how), _at(column, i, 1, how)))
        else:
            quads = _at(column, i, 0, how), _at(column, i, 1, how), _at(column, i, 2, how), _at(column, i, 3, how)
            store_quads(row, 4 * i, quads)


@inlined
def _before(y: int, factor: int) -> int:
    """Return the reduced row whose centre is the last one before that of row y at full size; -1 before the first."""
    return y // factor - (1 if 2 * (y % factor) + 1 < factor else 0)


@inlined
def _at(column: Float64, i: int, phase: int, how: Enlargement) -> Doubles:
    """Return sixteen pixels of one phase, float32: those in the reduced pixels i .. i + 15 of ``column``."""
    first = REACH + i - (2 if 2 * phase + 1 < how.factor else 1)
    total = how.phases[phase, 0] * load(column, first) + how.phases[phase, 1] * load(column, first + 1)
    total = total + how.phases[phase, 2] * load(column, first + 2) + how.phases[phase, 3] * load(column, first + 3)
    return from_doubles(total)
