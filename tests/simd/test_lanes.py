"""The vector layer against NumPy: every operation on sixteen numbers at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numba import njit

from flowabs_nodes.simd import avx512, lanes, memory
from flowabs_nodes.simd.lanes import LANES, lane_indices, select
from flowabs_nodes.simd.memory import load, store

RANDOM = np.random.default_rng(16)
X, Y = (RANDOM.normal(0, 30, LANES).astype(np.float32) for _ in range(2))
M, N = (RANDOM.integers(-1000, 1000, LANES).astype(np.int32) for _ in range(2))


def kernel(operation: Callable[..., Any]) -> Callable[..., np.ndarray]:
    """``operation`` on vectors as a function of arrays of sixteen."""
    operation = njit(error_model="numpy")(operation)

    @njit(error_model="numpy")
    def calculate(x: Any, y: Any, out: Any) -> None:
        store(out, 0, operation(load(x, 0), load(y, 0)))

    def run(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        out = np.zeros_like(x)
        calculate(x, y, out)
        return out

    return run


@pytest.mark.parametrize(
    "operation",
    [
        lambda x, y: x + y,
        lambda x, y: x - 2.5,
        lambda x, y: 3 * y,
        lambda x, y: 1.0 / y,
        lambda x, y: -x,
    ],
)
def test_arithmetic_of_floats(operation: Callable[..., Any]) -> None:
    np.testing.assert_allclose(kernel(operation)(X, Y), operation(X, Y), rtol=1e-7)


@pytest.mark.parametrize(
    "operation",
    [
        lambda i, j: i + j,
        lambda i, j: i - 7,
        lambda i, j: i * j,
        lambda i, j: i & j,
        lambda i, j: i | 12,
        lambda i, j: i ^ j,
        lambda i, j: i << 3,
        lambda i, j: i >> 2,
        lambda i, j: -j,
    ],
)
def test_arithmetic_of_ints(operation: Callable[..., Any]) -> None:
    np.testing.assert_array_equal(kernel(operation)(M, N), operation(M, N))


@pytest.mark.parametrize(
    "compare",
    [
        lambda x, y: x < y,
        lambda x, y: x <= y,
        lambda x, y: x > 3,
        lambda x, y: x >= y,
        lambda x, y: x == y,
        lambda x, y: (x < y) & (x > 0),
        lambda x, y: (x < y) | (x > 0),
    ],
)
def test_comparisons_choose_lanes(compare: Callable[..., Any]) -> None:
    compiled = njit(compare)
    choose = kernel(lambda x, y: select(compiled(x, y), x, y + 1))
    for x, y in ((X, Y), (X, X), (M, N), (M, M)):
        np.testing.assert_array_equal(choose(x, y), np.where(compare(x, y), x, y + x.dtype.type(1)))


HALVES = np.arange(-8, 8).astype(np.float32) / 2


@pytest.mark.parametrize(
    ("operation", "expected"),
    [
        (lambda x, _: lanes.floor(x), np.floor),
        (lambda x, _: lanes.rint(x), np.rint),
        (lambda x, _: lanes.absolute(x), np.abs),
        (lambda x, _: lanes.sqrt(lanes.absolute(x)), lambda x: np.sqrt(np.abs(x))),
        (lambda x, _: lanes.to_floats(lanes.to_ints(x)), np.trunc),
        (lambda x, _: lanes.from_bits(lanes.bits_of(x)), lambda x: x),
        (lambda x, _: lanes.from_doubles(lanes.to_doubles(x) * 3), lambda x: x * 3),
        (lambda x, _: lanes.minimum(x, 1), lambda x: np.minimum(x, 1)),
        (lambda x, _: lanes.maximum(x, 1), lambda x: np.maximum(x, 1)),
    ],
)
def test_functions(operation: Callable[..., Any], expected: Callable[..., Any]) -> None:
    run = kernel(operation)
    for x in (X, HALVES):
        np.testing.assert_array_equal(run(x, x), expected(x))


def test_doubles_are_exact_where_floats_are_not() -> None:
    """And tell what a float is the nearest to."""

    @njit(error_model="numpy")
    def calculate(x: Any, out: Any) -> None:
        one_more = lanes.to_doubles(load(x, 0)) + 1.0
        sum_of_squares = one_more * one_more - lanes.sqrt(one_more) * lanes.sqrt(one_more)
        store(out, 0, lanes.from_doubles(select(one_more > 1.0, sum_of_squares, one_more)))

    x, out = 2.0 ** np.arange(-47, -31, dtype=np.float32), np.zeros(LANES, np.float32)
    calculate(x, out)
    np.testing.assert_allclose(out, x, rtol=0.1)  # (1 + x)^2 - (1 + x): 1 + x is just 1 in float32


def test_rough_inverse_root() -> None:
    """Its bound, over all of float32."""
    inverse_root = kernel(lambda x, _: avx512.approximate_rsqrt(x))
    for x in np.logspace(-37, 38, 320).reshape(-1, LANES).astype(np.float32):
        np.testing.assert_allclose(inverse_root(x, x), x.astype(np.float64) ** -0.5, rtol=2.0**-13)


PICTURE = np.arange(100, dtype=np.float32) ** 2
PLACES = RANDOM.integers(0, 92, LANES).astype(np.int32)


@njit
def _read_at_places(picture: Any, places: Any, out: Any) -> None:
    kept = memory.scratch(np.int32, 2)
    store(kept, 16, load(places, 0))
    for k, each in enumerate(memory.gather_pairs(picture, kept, 16)):
        store(out, 16 * k, each)
    for k, each in enumerate(memory.gather_quads(picture, kept, 16)):
        store(out, 32 + 16 * k, each)
    for k, each in enumerate(memory.gather_octets(picture, kept, 16)):
        store(out, 96 + 16 * k, each)


def test_reading_at_scattered_places() -> None:
    out = np.zeros(14 * LANES, np.float32)
    _read_at_places(PICTURE, PLACES, out)
    offsets = [*range(2), *range(4), *range(8)]
    np.testing.assert_array_equal(out.reshape(14, LANES), [PICTURE[PLACES + k] for k in offsets])


@njit
def _read_pairs(picture: Any, places: Any, out: Any) -> None:
    kept = memory.scratch(np.int32, 1)
    store(kept, 0, load(places, 0))
    for k, each in enumerate(memory.gather_quads(picture, kept, 0)):
        store(out, 16 * k, each)
    for k, each in enumerate(memory.load_pairs(picture, 3)):
        store(out, 64 + 16 * k, each)
    memory.store_pairs(picture, 3, (load(out, 0), load(out, 16)))


def test_complex_numbers_are_pairs() -> None:
    out, picture = np.zeros(6 * LANES, np.float32), PICTURE[: PICTURE.size // 2 * 2].copy()
    numbers, places = picture.view(np.complex64), (PLACES // 2).astype(np.int32)
    _read_pairs(numbers, places, out)
    expected = [PICTURE[2 * places + k] for k in range(4)]
    neighbours = PICTURE[6 : 6 + 2 * LANES]
    np.testing.assert_array_equal(out.reshape(6, LANES), [*expected, neighbours[::2], neighbours[1::2]])
    np.testing.assert_array_equal(picture[6 : 6 + 2 * LANES], np.stack(expected[:2], -1).ravel())


@njit
def _by_way_of_scratch(x: Any, whole: Any, nearest: Any, ties_to_even: Any, below: Any) -> None:
    kept = memory.scratch(np.float64, 3)
    store(kept, 32, lanes.to_doubles(load(x, 0)))
    memory.prefetch(x, 10**9)  # only ever a hint
    memory.prefetch_for_write(x, -1)
    store(whole, 0, lanes.to_ints(load(kept, 32)))
    store(nearest, 0, lanes.rint(load(kept, 32)))
    store(ties_to_even, 0, lanes.round_to_ints(load(kept, 32)))
    store(below, 0, lanes.floor(load(kept, 32)))


def test_doubles_in_scratch_memory() -> None:
    whole, even = np.zeros((2, LANES), np.int32)
    nearest, below = np.zeros((2, LANES))
    x = np.where(np.arange(LANES) < 8, np.arange(LANES) - 3.5, X).astype(np.float32)
    _by_way_of_scratch(x, whole, nearest, even, below)
    np.testing.assert_array_equal(whole, np.trunc(x))
    np.testing.assert_array_equal(nearest, np.rint(x))
    np.testing.assert_array_equal(even, np.rint(x))
    np.testing.assert_array_equal(below, np.floor(x))


@njit
def _take_apart(records: Any, out: Any, again: Any) -> None:
    pairs, triples = memory.load_pairs(records, 1), memory.load_triples(records, 1)
    quads = memory.load_quads(records, 1)
    for k in range(2):
        store(out, 16 * k, pairs[k])
    for k in range(3):
        store(out, 32 + 16 * k, triples[k])
    for k in range(4):
        store(out, 80 + 16 * k, quads[k])
    memory.store_pairs(again, 0, pairs)
    memory.store_triples(again, 32, triples)
    memory.store_quads(again, 80, quads)


def test_neighbouring_records_come_apart_and_together() -> None:
    out, again = np.zeros(9 * LANES, np.float32), np.zeros(9 * LANES, np.float32)
    _take_apart(PICTURE, out, again)
    first = 0
    for size in (2, 3, 4):
        last = first + size * LANES
        records = PICTURE[1 : 1 + size * LANES]
        np.testing.assert_array_equal(out[first:last].reshape(size, LANES), records.reshape(LANES, size).T)
        np.testing.assert_array_equal(again[first:last], records)
        first = last


def test_look_up_in_a_table_of_sixteen() -> None:
    np.testing.assert_array_equal(kernel(lambda table, i: avx512.table_lookup(table, i))(M, N), M[N & 15])


def test_sums_along_the_lanes() -> None:
    np.testing.assert_array_equal(kernel(lambda i, _: lanes.prefix_sums(i))(M, M), np.cumsum(M))
    np.testing.assert_array_equal(kernel(lambda i, _: lanes.last_lane(i))(M, M), np.full(LANES, M[-1]))


def test_lanes_are_numbered() -> None:
    np.testing.assert_array_equal(kernel(lambda i, _: i * 0 + lane_indices())(M, M), np.arange(LANES))


@pytest.mark.parametrize("lane", [None, 0, 15])
def test_any_lane(lane: int | None) -> None:
    x = np.zeros(LANES, np.float32)
    if lane is not None:
        x[lane] = 1

    @njit
    def any_above(x: Any) -> bool:
        return lanes.any_lane(load(x, 0) > 0.5)

    assert any_above(x) == (lane is not None)
