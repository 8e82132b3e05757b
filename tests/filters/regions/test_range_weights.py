"""Means among similar colours against NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters.regions.range_weights import (
    add_sample,
    load_color,
    load_sums,
    partial_coverage,
    range_exponent,
    record_size,
    smooth_by_passes,
    spatial_exponents,
    start_sums,
    store_mean,
    store_sums,
)
from flowabs_nodes.sampling.coords import raster_of
from flowabs_nodes.simd.lanes import LANES
from flowabs_nodes.simd.memory import scratch

RANDOM = np.random.default_rng(7)


@njit(error_model="numpy")
def _mean(picture: Any, spatial_exponents: Any, range_exponent: float, alpha: Any, smoothed: Any) -> None:
    """Of the first sixteen records, with the next sixteen, and the sixteen after those."""
    so_far, centre = scratch(np.float32, 8), load_color(picture, 0, alpha)
    store_sums(so_far, 1, start_sums(centre))
    for k in range(1, 3):
        store_sums(
            so_far,
            1,
            add_sample(
                load_sums(so_far, 1),
                centre,
                load_color(picture, k * LANES, alpha),
                spatial_exponents[k],
                range_exponent,
                alpha,
            ),
        )
    store_mean(load_sums(so_far, 1), centre, smoothed, 0, alpha)


@pytest.mark.parametrize("size", [3, 4])
def test_weighted_means(size: int) -> None:
    picture = RANDOM.uniform(0, 100, (3, LANES, size)).astype(np.float32)
    alpha = np.ones((3, LANES, 1))
    if size == 4:
        alpha = picture[..., 3:] = np.where(RANDOM.random((3, LANES, 1)) < 0.4, 0, RANDOM.random((3, LANES, 1)))
    smoothed = np.zeros((LANES, size), np.float32)
    _mean(
        picture.reshape(-1), spatial_exponents(2), range_exponent(30), None if size == 3 else True, smoothed.reshape(-1)
    )
    colors = picture[..., :3].astype(np.float64)
    distance = np.linalg.norm(colors - colors[0], axis=-1, keepdims=True)
    weights = alpha * np.exp(-(np.arange(3).reshape(3, 1, 1) ** 2) / 8) * np.exp(-(distance**2) / 1800)
    total = weights.sum(0)
    expected = np.where(alpha[0] > 0, (weights * colors).sum(0) / np.where(total > 0, total, 1), colors[0])
    np.testing.assert_allclose(smoothed[:, :3], expected, rtol=0, atol=1e-3)
    if size == 4:
        np.testing.assert_array_equal(smoothed[:, 3:], alpha[0].astype(np.float32))


def test_floats_of_a_record() -> None:
    assert [njit(record_size.py_func)(alpha) for alpha in (None, True)] == [3, 4]


@pytest.mark.parametrize("shape", [(3, 20), (4, 5), (1, 1)])
@pytest.mark.parametrize("with_alpha", [False, True])
def test_passes_take_turns(shape: tuple[int, int], with_alpha: bool) -> None:
    codes, calls = RANDOM.random((*shape, 3)).astype(np.float32), []
    alpha = np.full(shape, 0.5, np.float32) if with_alpha else None

    def adding(number: float) -> Any:
        def smooth(picture: Any, smoothed: Any) -> None:
            calls.append(number)
            smoothed[:] = picture + np.float32(number)

        return smooth

    result = smooth_by_passes(codes, alpha, raster_of(codes), [adding(1), adding(20)], 3)
    assert calls == [1, 20] * 3
    assert result.flags.c_contiguous
    np.testing.assert_allclose(result, codes + 63, rtol=1e-6)
    same = smooth_by_passes(codes, alpha, raster_of(codes), [adding(1)], 0)
    np.testing.assert_array_equal(same, codes)
    assert not np.shares_memory(same, codes)


@pytest.mark.parametrize("width", [3, 16, 40])
def test_records_have_the_alpha_that_counts(width: int) -> None:
    codes, seen = RANDOM.random((2, width, 3)).astype(np.float32), []
    alpha = RANDOM.choice([1, 0.5, 0, -1, 1e-30, 1e-10], (2, width)).astype(np.float32)

    def look(picture: Any, smoothed: Any) -> None:
        seen.append(picture[:-2].reshape(2, -1, 4)[:, :width].copy())
        smoothed[:] = picture

    result = smooth_by_passes(codes, alpha, raster_of(codes), [look], 1)
    np.testing.assert_array_equal(seen[0][..., :3], codes)
    np.testing.assert_array_equal(seen[0][..., 3], np.where(alpha > 1e-20, alpha, 0))
    np.testing.assert_array_equal(result, codes)


def test_coverage() -> None:
    codes = np.zeros((2, 3, 3), np.float32)
    assert partial_coverage(None, codes) is None
    assert partial_coverage(np.ones((2, 3)), codes) is None
    alpha = np.array([[1, 0.5, 0], [-1, 1e-30, 1e-10]])
    np.testing.assert_array_equal(partial_coverage(alpha, codes), alpha.astype(np.float32))
    with pytest.raises(ArgumentError, match="alpha"):
        partial_coverage(np.ones((3, 2)), codes)
