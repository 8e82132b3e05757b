"""Eq. 10: a picture summed along the gradient axis l_x (section 3.1), unit steps along (t.y, -t.x), across the flow."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
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

_STEPS = 8  # whose places are worked out together: the loads of one need not wait for those of another


def across(planes: Array, flow: Array, taps: npt.NDArray[np.float64]) -> Array:
    """The weighted sum of each of some planes (C, H, W) over the gradient axis of each pixel, read bilinearly.

    ``taps`` are the weights f of the steps 0, 1 .. to either side.
    """
    result = over_tiles(_across, planes, flow, taps)
    return exact_sum(planes, flow, taps, np.ones(1), "bilinear") if result is None else result


@kernel
def _across(first: int, last: int, planes: Any, shape: PlanesShape, flow: Any, taps: Any, result: Any) -> bool:
    """Whether all tangents were short enough."""
    channels, height, width = shape
    steps = taps.size - 1
    places, u, v = scratch(np.int32, 16), scratch(np.float32, 8), scratch(np.float32, 8)
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
                        for n0 in range(1, steps + 1, _STEPS):
                            n_end = min(n0 + _STEPS, steps + 1)
                            for n in range(n0, n_end):
                                _find(n, tx, ty, x, y, around, places, u, v, n - n0)
                            for n in range(n0, n_end):
                                total = total + _both_sides(lattice, places, u, v, n - n0) * taps[n]
                        store(result, at, total)
    return True


@inlined
def _find(n: int, tx: Any, ty: Any, x: int, y: int, tile: Tile, places: Any, u: Any, v: Any, k: int) -> None:
    """The k-th places: l_x(n) and l_x(-n)."""
    dx, dy = ty * np.float32(n), tx * np.float32(-n)
    left, top = floor(dx), floor(dy)
    store(u, LANES * k, dx - left)
    store(v, LANES * k, dy - top)
    columns, rows, pixel = to_ints(left), to_ints(top), lane_indices() + x
    store(places, 2 * LANES * k, tile_offset(pixel + columns, rows + y, tile))
    store(places, 2 * LANES * k + LANES, tile_offset(pixel - 1 - columns, -1 - rows + y, tile))


@inlined
def _both_sides(lattice: Any, places: Any, u: Any, v: Any, k: int) -> Any:
    """What is at the k-th places."""
    u, v = load(u, LANES * k), load(v, LANES * k)
    other = sample_lattice(lattice, places, 2 * LANES * k + LANES, 1.0 - u, 1.0 - v)
    return sample_lattice(lattice, places, 2 * LANES * k, u, v) + other
