"""The vector layer against NumPy: every operation on sixteen numbers at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numba import njit

from flowabs_nodes.simd import lanes
from flowabs_nodes.simd.lanes import LANES, lane_indices, select
from flowabs_nodes.simd.memory import load, store

RANDOM = np.random.default_rng(16)
X, Y = (RANDOM.normal(0, 30, LANES).astype(np.float32) for _ in range(2))
M, N = (RANDOM.integers(-1000, 1000, LANES).astype(np.int32) for _ in range(2))


def kernel(operation: Callable[..., Any]) -> Callable[..., np.ndarray]:
    """Return ``operation``, of two vectors, as a function of two arrays of sixteen."""
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


def test_set_lanes() -> None:
    x = np.random.default_rng(4).random(LANES, np.float32)

    @njit
    def above(x: Any) -> int:
        return lanes.set_lanes(load(x, 0) > 0.5)

    assert above(x) == sum(2**k for k in range(LANES) if x[k] > 0.5)
