"""Eq. 10: the weighted sum of a picture along the gradient axis l_x (section 3.1), at whole steps along (t.y, -t.x).

Samples are bilinear, from a tile of the picture that is laid out as a lattice
(:mod:`~flowabs_nodes.sampling.tile_cache`).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array, Int32
from flowabs_nodes.sampling.exact_sums import exact_sum
from flowabs_nodes.sampling.tile_cache import (
    COLUMNS,
    ROWS,
    PlanesShape,
    Tile,
    fill_lattice,
    is_short,
    over_tiles,
    sample_lattice,
    tile_around,
    tile_capacity,
    tile_offset,
)
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, floor, lane_indices, to_ints
from flowabs_nodes.simd.memory import load, load_pairs, scratch, store

_STEPS = 8  # are located before the first of them is sampled, so that gathers need not wait for each other


def across(planes: Array, flow: Array, taps: npt.NDArray[np.float64]) -> Array:
    """Return the weighted sum of each of some planes over the gradient axis of each pixel, sampled bilinearly (eq. 10).

    Parameters
    ----------
    planes
        (C, H, W) float32.
    flow
        (H, W, 2) float32 tangents.
    taps
        The filter f at the steps t = 0, 1 .. T; it is symmetric.

    Returns
    -------
    (C, H, W) float32. Tangents too long for tiles, far from unit length, take the slower path of
    :func:`~flowabs_nodes.sampling.exact_sums.exact_sum`.
    """
    result = over_tiles(_across, planes, flow, taps)
    return exact_sum(planes, flow, taps, np.ones(1), "bilinear") if result is None else result


@kernel
def _across(
    first: int,
    last: int,
    planes: Array,
    shape: PlanesShape,
    flow: npt.NDArray[np.complex64],
    taps: Array,
    result: Array,
) -> bool:
    """Write rows ``first`` .. ``last`` - 1 of H_g (eq. 10); return whether no tangent was too long.

    ``planes`` and ``result`` are (C, H, W) float32, ``flow`` (H, W) complex64, all flattened.
    """
    channels, height, width = shape
    steps, apart = taps.size - 1, _steps_apart(taps)
    # Of the points l_x(n) and l_x(-n) of sixteen pixels at up to eight steps: the lattice entry to the upper left of
    # each, and how far (u, v) beyond its entry l_x(n) lies; l_x(-n) lies (1 - u, 1 - v) beyond its own.
    entries, offsets = scratch(np.int32, 16), scratch(np.float32, 16)
    lattice = np.empty(tile_capacity(steps, last - first, width, height), np.complex64)
    for y0 in range(first, last, ROWS):
        for x0 in range(0, width, COLUMNS):
            y_end, x_end = min(y0 + ROWS, last), min(x0 + COLUMNS, width)
            around = tile_around(x0, y0, x_end, y_end, steps, width, height)
            for c in range(channels):
                fill_lattice(lattice, planes, c * height * width, around)
                for y in range(y0, y_end):
                    for each in range(x0, x_end, LANES):
                        x = min(each, width - LANES)
                        tx, ty = load_pairs(flow, y * width + x)
                        if not is_short(tx, ty):
                            return False
                        at = (c * height + y) * width + x
                        total = load(planes, at) * taps[0]
                        for n0 in range(apart, steps + 1, apart * _STEPS):
                            located = min((steps - n0) // apart + 1, _STEPS)
                            for k in range(located):
                                n = n0 + k * apart
                                dx, dy = ty * np.float32(n), tx * np.float32(-n)
                                locate_both_sides(dx, dy, x, y, around, entries, offsets, k)
                            for k in range(located):
                                n = n0 + k * apart
                                samples = _sample_both_sides(lattice, entries, offsets, k)
                                total = total + samples * taps[n]  # eq. 10
                        store(result, at, total)
    return True


@inlined
def _steps_apart(taps: Array) -> int:
    """Return how many steps lie between the samples that count: 1, or more where all ``taps`` in between are 0."""
    apart = 1
    for each in range(2, taps.size):
        between = 0
        for n in range(1, taps.size):
            between += 1 if n % each != 0 and taps[n] != 0 else 0
        apart = each if between == 0 else apart
    return apart


@inlined
def locate_both_sides(dx: Any, dy: Any, x: int, y: int, tile: Tile, entries: Int32, offsets: Array, k: int) -> None:
    """Write where the points (dx, dy) and (-dx, -dy) from the pixels x .. x + 15 of row y are, as the k-th points."""
    left, top = floor(dx), floor(dy)
    store(offsets, 2 * LANES * k, dx - left)
    store(offsets, 2 * LANES * k + LANES, dy - top)
    columns, rows, pixel = to_ints(left), to_ints(top), lane_indices() + x
    store(entries, 2 * LANES * k, tile_offset(pixel + columns, rows + y, tile))
    store(entries, 2 * LANES * k + LANES, tile_offset(pixel - 1 - columns, -1 - rows + y, tile))


@inlined
def _sample_both_sides(lattice: npt.NDArray[np.complex64], entries: Int32, offsets: Array, k: int) -> Any:
    """Return the sum of the samples at the k-th points: I(l_x(n)) + I(l_x(-n))."""
    u, v = load(offsets, 2 * LANES * k), load(offsets, 2 * LANES * k + LANES)
    other = sample_lattice(lattice, entries, 2 * LANES * k + LANES, 1.0 - u, 1.0 - v)
    return sample_lattice(lattice, entries, 2 * LANES * k, u, v) + other
