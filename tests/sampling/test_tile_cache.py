"""Tiles against the whole picture in float64."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit

from flowabs_nodes.sampling import tile_cache
from flowabs_nodes.simd.lanes import LANES
from flowabs_nodes.simd.memory import load, scratch, store
from tests.filters.flows import random_flow
from tests.filters.pictures import noise
from tests.naive import streamline as naive

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
def _fill(flow: Any, planes: Any, edges: Any) -> tuple[bool, bool]:
    x, y, x_end, y_end = edges
    tile = tile_cache.tile_around(x, y, x_end, y_end, STEPS, WIDTH, HEIGHT)
    size = tile_cache.tile_capacity(STEPS, HEIGHT, WIDTH, HEIGHT)
    tangents, records = np.zeros(size, np.complex64), np.zeros(2 * size, np.complex64)
    return (
        tile_cache.fill_tangents(tangents, flow, tile),
        tile_cache.fill_records(records, flow, planes, (0, 0), tile),
    )


def test_tangents_that_are_too_long_are_found_where_a_tile_reaches_them() -> None:
    flow, plane = random_flow((HEIGHT, WIDTH)), np.zeros(WIDTH * HEIGHT, np.float32)
    flow[50, 20] = (0.1, -1.3)
    tangents = flow.reshape(-1).view(np.complex64)
    assert _fill(tangents, plane, (12, 40, 12 + LANES, 41)) == (False, False)
    assert _fill(tangents, plane, (12, 1, 12 + LANES, 2)) == (True, True)


def test_a_kernel_in_tiles_gives_nothing_where_it_finds_a_long_tangent() -> None:
    planes, flow = noise(HEIGHT, WIDTH)[None], random_flow((HEIGHT, WIDTH))

    def double(first, last, planes, shape, flow, weights, result):
        row = slice(first * shape.width, last * shape.width)
        result[row] = planes[row] * weights[1]
        return bool((abs(flow[row]) < 1.3).all())

    np.testing.assert_array_equal(tile_cache.over_tiles(double, planes, flow, np.array([1, 2])), 2 * planes)
    flow[50, 20] = (0.1, -1.3)
    assert tile_cache.over_tiles(double, planes, flow, np.array([1, 2])) is None
