"""A pyramid that sums planes over Gaussians of growing scale, nearly exactly, whatever grid its samples lie on.

Two sweeps, both linear:

- *Push*: smooth by a binomial filter of order 12 and keep every second sample, level by level.
- *Pull*: coming up again, put zeros between the samples, smooth by the same filter, and add the finer level.

Level k is then smoothed by a B-spline of degree 11 and step 2^k, nearly a Gaussian of sigma 1.4 * 2^k pixels. It is so
smooth for its step that sampling folds back less than 3e-4 of it at the first level and 1e-4 at the others. So the sums
of a picture that is shifted, mirrored or turned are the same, shifted, mirrored or turned.

A level is an array (planes, rows, columns). Sample i of an axis is at pixel 2^k i and at position i + MARGIN of the
array, so that samples outside the picture whose filter reaches into it have a place. Rows are padded to whole vectors
of pairs.
"""

from __future__ import annotations

import math

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, Floats
from flowabs_nodes.simd.memory import load, load_pairs, store, store_pairs

#: How many samples a level has before the picture's first: as many as the binomial filter reaches.
MARGIN = 6
#: Rows of a ring buffer: at least the thirteen of the filter, a power of two.
RING = 16
#: The weight of each scale's Gaussian, whose integral is 1, beside that of the next finer scale.
DECAY = 0.5

_B0, _B1, _B2, _B3, _B4, _B5, _B6 = (math.comb(12, 6 + j) / 2**12 for j in range(MARGIN + 1))


def first_level(planes: int, height: int, width: int) -> Array:
    """Return an uninitialised first level over a picture of ``height`` x ``width`` pixels."""
    rows, columns = (MARGIN + _samples(size, 1) for size in (height, width))
    return np.empty((planes, rows, _padded(columns)), np.float32)


def sum_over_scales(level: Array, height: int, width: int) -> None:
    """Add to the first level, in place, all coarser levels up to the size of the picture, each with half the weight."""
    levels = [level]
    while 2 ** len(levels) < max(height, width) / 2:
        rows, columns = (MARGIN + _samples(size, len(levels) + 1) for size in (height, width))
        levels.append(np.empty((level.shape[0], rows, _padded(columns)), np.float32))
        over_rows(_push, rows, levels[-2], levels[-1], least=_worth_a_thread(levels[-1]))
    while len(levels) > 1:
        coarse = levels.pop()
        over_rows(_pull, levels[-1].shape[1], coarse, levels[-1], least=_worth_a_thread(levels[-1]))


def _samples(size: int, level: int) -> int:
    """Return how many samples a level has on an axis of ``size`` pixels, from the picture's first pixel on."""
    for _ in range(level):
        size = (size - 1 + MARGIN) // 2 + 1
    return size


def _padded(columns: int) -> int:
    """Return a number of columns that is whole vectors of pairs."""
    return -(-columns // (2 * LANES)) * 2 * LANES


def _worth_a_thread(level: Array) -> int:
    """Return how many rows of a level take longer to make than it takes to wake a thread."""
    columns: int = level.shape[2]
    return max(32, 2**15 // columns)


@kernel
def _push(first: int, last: int, fine: Array, level: Array) -> None:
    """Write the rows ``first`` .. ``last`` - 1 of a level from the next finer one."""
    stride = level.shape[2]
    even, odd = np.zeros(stride + 2 * LANES, np.float32), np.zeros(stride + 2 * LANES, np.float32)
    ring = np.zeros((RING, level.shape[0], stride), np.float32)
    for y in range(2 * (first - MARGIN) - MARGIN, 2 * (last - 1 - MARGIN) + MARGIN + 1):
        if 0 <= y + MARGIN < fine.shape[1]:
            for p in range(level.shape[0]):
                halve_row(fine[p, y + MARGIN], min(2 * stride, fine.shape[2]), even, odd, ring[y % RING, p])
        else:
            ring[y % RING] = 0
        j = (y - MARGIN) // 2 + MARGIN
        if y % 2 == 0 and j >= first:
            for p in range(level.shape[0]):
                smooth_rows(ring, p, y - MARGIN, level[p, j])


@inlined
def halve_row(row: Array, size: int, even: Array, odd: Array, halved: Array) -> None:
    """Smooth a row of a level along x and keep its even samples.

    ``size`` is the number of items of ``row`` that may be other than zero; ``even`` and ``odd`` are room for twice as
    many vectors as they take, zero beyond them.
    """
    for e in range(0, (size + 1) // 2, LANES):
        a, b = load_pairs(row, 2 * e)
        store(even, MARGIN + e, a)
        store(odd, MARGIN + e, b)
    for i in range(0, halved.size, LANES):  # even[i + 3] is sample 2 (i - MARGIN), odd[i + 3] its right neighbour
        total = _B6 * (load(even, i) + load(even, i + 6)) + _B5 * (load(odd, i) + load(odd, i + 5))
        total = total + _B4 * (load(even, i + 1) + load(even, i + 5)) + _B3 * (load(odd, i + 1) + load(odd, i + 4))
        total = total + _B2 * (load(even, i + 2) + load(even, i + 4)) + _B1 * (load(odd, i + 2) + load(odd, i + 3))
        store(halved, i, total + _B0 * load(even, i + 3))


@inlined
def smooth_rows(ring: Array, p: int, y: int, smoothed: Array) -> None:
    """Write the weighted sum of plane p of the thirteen rows around row y, which lie at their index modulo RING."""
    for i in range(0, smoothed.size, LANES):
        total = _B6 * (load(ring[(y - 6) % RING, p], i) + load(ring[(y + 6) % RING, p], i))
        total = total + _B5 * (load(ring[(y - 5) % RING, p], i) + load(ring[(y + 5) % RING, p], i))
        total = total + _B4 * (load(ring[(y - 4) % RING, p], i) + load(ring[(y + 4) % RING, p], i))
        total = total + _B3 * (load(ring[(y - 3) % RING, p], i) + load(ring[(y + 3) % RING, p], i))
        total = total + _B2 * (load(ring[(y - 2) % RING, p], i) + load(ring[(y + 2) % RING, p], i))
        total = total + _B1 * (load(ring[(y - 1) % RING, p], i) + load(ring[(y + 1) % RING, p], i))
        store(smoothed, i, total + _B0 * load(ring[y % RING, p], i))


@inlined
def enlarge_rows(coarse: Array, y: int, smoothed: Array) -> None:
    """Write a plane of a coarser level, smoothed along y at row y of the finer one, into ``smoothed``."""
    i = y // 2 + MARGIN
    for x in range(0, coarse.shape[1], LANES):
        if y % 2 == 0:
            total = _B6 * (load(coarse[i - 3], x) + load(coarse[i + 3], x))
            total = total + _B4 * (load(coarse[i - 2], x) + load(coarse[i + 2], x))
            total = total + _B2 * (load(coarse[i - 1], x) + load(coarse[i + 1], x))
            store(smoothed, x, 2.0 * (total + _B0 * load(coarse[i], x)))
        else:
            total = _B5 * (load(coarse[i - 2], x) + load(coarse[i + 3], x))
            total = total + _B3 * (load(coarse[i - 1], x) + load(coarse[i + 2], x))
            store(smoothed, x, 2.0 * (total + _B1 * (load(coarse[i], x) + load(coarse[i + 1], x))))


@inlined
def enlarged_row(smoothed: Array, e: int) -> tuple[Floats, Floats]:
    """Return the positions 2e, 2e + 2 .. and 2e + 1, 2e + 3 .. of a row of the finer level, smoothed along x."""
    even = _B6 * (load(smoothed, e) + load(smoothed, e + 6)) + _B4 * (load(smoothed, e + 1) + load(smoothed, e + 5))
    even = even + _B2 * (load(smoothed, e + 2) + load(smoothed, e + 4))
    odd = _B5 * (load(smoothed, e + 1) + load(smoothed, e + 6)) + _B3 * (load(smoothed, e + 2) + load(smoothed, e + 5))
    odd = odd + _B1 * (load(smoothed, e + 3) + load(smoothed, e + 4))
    return 2.0 * (even + _B0 * load(smoothed, e + 3)), 2.0 * odd


@kernel
def _pull(first: int, last: int, coarse: Array, level: Array) -> None:
    """Add the next coarser level, enlarged, to the rows ``first`` .. ``last`` - 1 of a level."""
    smoothed = np.zeros(max(coarse.shape[2], level.shape[2] // 2) + 2 * LANES, np.float32)
    for j in range(first, last):
        for p in range(level.shape[0]):
            enlarge_rows(coarse[p], j - MARGIN, smoothed)
            for e in range(0, level.shape[2] // 2, LANES):
                own_even, own_odd = load_pairs(level[p, j], 2 * e)
                even, odd = enlarged_row(smoothed, e)
                store_pairs(level[p, j], 2 * e, (own_even + DECAY * even, own_odd + DECAY * odd))
