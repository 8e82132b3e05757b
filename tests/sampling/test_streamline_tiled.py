"""Streamlines in a tile against section 3.3 in float64: the same pixels, the same offsets."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit

from flowabs_nodes.sampling import tile_cache
from flowabs_nodes.sampling.streamline_tiled import advance, fraction_beyond, new_tiled_streamlines, start, turn
from flowabs_nodes.simd.lanes import LANES, to_floats
from flowabs_nodes.simd.memory import gather_pairs, load, load_pairs, store
from tests.filters.flows import cases, random_flow
from tests.naive import streamline as naive

WIDTH, HEIGHT, STEPS = 41, 60, 20


@njit(error_model="numpy")
def _follow(flow: Any, pixels: Any, x0: int, y: int, way: int, nearest: Any, dx: Any, dy: Any) -> bool:
    """Write the values of ``pixels`` nearest to z, and the distances of z from its corner, after each step."""
    curves = new_tiled_streamlines()
    tile = tile_cache.tile_around(x0, y, x0 + LANES, y + 1, STEPS, WIDTH, HEIGHT)
    records = np.zeros(2 * tile_cache.tile_capacity(STEPS, HEIGHT, WIDTH, HEIGHT), np.complex64)
    if not tile_cache.fill_records(records, flow, pixels, (0, 0), tile):
        return False
    tx, ty = load_pairs(flow, y * WIDTH + x0)
    start(curves, 0, x0, y, tx * (1 - 2 * way), ty * (1 - 2 * way))
    for s in range(1, STEPS + 1):
        advance(curves, 0, s, tile, 2)
        tx, ty = gather_pairs(records, curves.nearest, 0)
        turn(curves, 0, tx, ty)
        at = LANES * (s - 1)
        store(nearest, at, to_floats(load(curves.nearest, 0)))
        for lane in range(LANES):
            nearest[at + lane] = records[int(nearest[at + lane]) + 1].real
        store(dx, at, fraction_beyond(load(curves.dx, 0)))
        store(dy, at, fraction_beyond(load(curves.dy, 0)))
    return True


def _ties() -> Any:
    """Return tangents whose sums often lie half way between pixels."""
    choices = np.float32([[0.5, 0.0], [1.0, 0.0], [0.5, 0.5], [0.0, -0.5], [-1.0, 0.5], [0.25, 0.75], [1.25, -1.25]])
    return choices[np.random.default_rng(3).integers(0, len(choices), (HEIGHT, WIDTH))]


FLOWS = {
    "random": random_flow((HEIGHT, WIDTH)),
    "noise": cases()["noise"][1],
    "ties": _ties(),
    "longer": 1.25 * random_flow((HEIGHT, WIDTH), seed=1),
    "none": np.zeros((HEIGHT, WIDTH, 2), np.float32),
    "60 degrees": np.broadcast_to(np.float32([0.5, np.sqrt(0.75)]), (HEIGHT, WIDTH, 2)).copy(),
    "45 degrees": np.broadcast_to(np.float32(np.sqrt([0.5, 0.5])), (HEIGHT, WIDTH, 2)).copy(),
}


@pytest.mark.parametrize("name", FLOWS)
@pytest.mark.parametrize("way", [0, 1])
def test_streamlines_are_those_of_exact_arithmetic(name: str, way: int) -> None:
    flow = FLOWS[name]
    pixels = np.arange(WIDTH * HEIGHT, dtype=np.float32)
    expected = list(naive.curve(flow, STEPS, 1 - 2 * way))
    for x0, y in [(0, 0), (25, 59), (12, 30), (25, 3)]:
        nearest, dx, dy = np.zeros((3, STEPS, LANES), np.float32)
        assert _follow(
            flow.reshape(-1).view(np.complex64), pixels, x0, y, way, *(each.reshape(-1) for each in (nearest, dx, dy))
        )
        here = np.s_[y, x0 : x0 + LANES]
        for s, (x_off, y_off, _) in enumerate(expected):
            where = naive.nearest(pixels.reshape(HEIGHT, WIDTH), x_off, y_off)
            np.testing.assert_array_equal(nearest[s], where[here])
            for found, offset in ((dx[s], x_off[here]), (dy[s], y_off[here])):
                error = (found - offset + 0.5) % 1 - 0.5
                assert abs(error).max() < 2e-7
