"""Tiles and the walks in them against the float64 reading."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit

from flowabs_nodes.sampling import tile_cache
from flowabs_nodes.sampling.streamline_tiled import advance, fraction_beyond, new_tiled_streamlines, start, turn
from flowabs_nodes.simd.lanes import LANES, to_floats
from flowabs_nodes.simd.memory import gather_pairs, load, load_pairs, scratch, store
from tests.filters.flows import cases, random_flow
from tests.filters.pictures import noise
from tests.naive import walk as naive

WIDTH, HEIGHT, STEPS = 41, 60, 20
EDGES = [(0, 0, 41, 60), (25, 50, 41, 60), (16, 30, 32, 31), (0, 59, 16, 60)]  # x, y, x_end, y_end of tiles


@njit(error_model="numpy")
def _read(plane: Any, columns: Any, rows: Any, u: Any, v: Any, edges: Any, out: Any) -> None:
    x, y, x_end, y_end = edges
    tile = tile_cache.tile_around(x, y, x_end, y_end, STEPS, WIDTH, HEIGHT)
    lattice, places = (
        np.zeros(tile_cache.tile_capacity(STEPS, HEIGHT, WIDTH, HEIGHT), np.complex64),
        scratch(np.int32, 1),
    )
    tile_cache.fill_lattice(lattice, plane, 0, tile)
    for k in range(0, out.size, LANES):
        store(places, 0, tile_cache.tile_offset(load(columns, k), load(rows, k), tile))
        store(out, k, tile_cache.sample_lattice(lattice, places, 0, load(u, k), load(v, k)))


@pytest.mark.parametrize("edges", EDGES)
def test_a_lattice_is_read_bilinearly_and_repeats_the_border(edges: tuple[int, int, int, int]) -> None:
    random, plane = np.random.default_rng(0), noise(HEIGHT, WIDTH)
    x, y, x_end, y_end = edges
    columns = random.integers(x - STEPS, x_end + STEPS, 640, dtype=np.int32)
    rows = random.integers(y - STEPS, y_end + STEPS, 640, dtype=np.int32)
    u, v = random.random((2, 640), np.float32)
    out = np.zeros(640, np.float32)
    _read(plane.reshape(-1), columns, rows, u, v, edges, out)
    expected = [naive.bilinear(plane, px, py)[0, 0] for px, py in zip(columns + 1.0 * u, rows + 1.0 * v, strict=True)]
    np.testing.assert_allclose(out, expected, atol=1e-4)


def test_planes_are_made_wide_by_repeating_the_border() -> None:
    wide = tile_cache.pad_width(noise(3, 5)[None], 2)
    assert wide.shape == (1, 3, LANES)
    np.testing.assert_array_equal(wide[0, :, 5:], np.repeat(noise(3, 5)[:, 4:], LANES - 5, 1))


@njit(error_model="numpy")
def _walk(flow: Any, pixels: Any, x0: int, y: int, way: int, nearest: Any, dx: Any, dy: Any) -> bool:
    """Values of ``pixels`` at the nearest pixel, and offsets from the corner, after each step."""
    walks = new_tiled_streamlines()
    tile = tile_cache.tile_around(x0, y, x0 + LANES, y + 1, STEPS, WIDTH, HEIGHT)
    records = np.zeros(2 * tile_cache.tile_capacity(STEPS, HEIGHT, WIDTH, HEIGHT), np.complex64)
    if not tile_cache.fill_records(records, flow, pixels, (0, 0), tile):
        return False
    tx, ty = load_pairs(flow, y * WIDTH + x0)
    start(walks, 0, x0, y, tx * (1 - 2 * way), ty * (1 - 2 * way))
    for s in range(1, STEPS + 1):
        advance(walks, 0, s, tile, 2)
        tx, ty = gather_pairs(records, walks.nearest, 0)
        turn(walks, 0, tx, ty)
        at = LANES * (s - 1)
        store(nearest, at, to_floats(load(walks.nearest, 0)))
        for lane in range(LANES):
            nearest[at + lane] = records[int(nearest[at + lane]) + 1].real
        store(dx, at, fraction_beyond(load(walks.dx, 0)))
        store(dy, at, fraction_beyond(load(walks.dy, 0)))
    return True


def _ties() -> Any:
    """Tangents whose sums lie half way between pixels, again and again."""
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
def test_walks_are_those_of_exact_arithmetic(name: str, way: int) -> None:
    flow = FLOWS[name]
    pixels = np.arange(WIDTH * HEIGHT, dtype=np.float32)
    expected = list(naive.curve(flow, STEPS, 1 - 2 * way))
    for x0, y in [(0, 0), (25, 59), (12, 30), (25, 3)]:
        nearest, dx, dy = np.zeros((3, STEPS, LANES), np.float32)
        assert _walk(
            flow.reshape(-1).view(np.complex64), pixels, x0, y, way, *(each.reshape(-1) for each in (nearest, dx, dy))
        )
        here = np.s_[y, x0 : x0 + LANES]
        for s, (x_off, y_off, _) in enumerate(expected):
            where = naive.nearest(pixels.reshape(HEIGHT, WIDTH), x_off, y_off)
            np.testing.assert_array_equal(nearest[s], where[here])
            for found, offset in ((dx[s], x_off[here]), (dy[s], y_off[here])):
                error = (found - offset + 0.5) % 1 - 0.5
                assert abs(error).max() < 2e-7


def test_tangents_that_are_too_long_are_found() -> None:
    flow = FLOWS["random"].copy()
    flow[50, 20] = (0.1, -1.3)
    pixels, outs = np.zeros(WIDTH * HEIGHT, np.float32), np.zeros((3, STEPS * LANES), np.float32)
    assert not _walk(flow.reshape(-1).view(np.complex64), pixels, 12, 40, 0, *outs)
    assert _walk(flow.reshape(-1).view(np.complex64), pixels, 12, 1, 0, *outs)
