"""Samples of records against float64: nearest and bilinear, with and without alpha."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from numba import njit

from flowabs_nodes.filters.regions.range_weights import record_size
from flowabs_nodes.sampling.coords import Raster, padded_rows, raster_of
from flowabs_nodes.sampling.samples import locate, new_sample_coords, prefetch_rows, row_below, sample
from flowabs_nodes.simd.lanes import LANES
from flowabs_nodes.simd.memory import load, store
from tests.naive.streamline import READ

SHAPES = [(9, 40), (2, 16), (1, 20), (6, 5), (5, 1), (1, 1)]


@njit(error_model="numpy")
def _read(picture: Any, dx: Any, dy: Any, bilinear: Any, alpha: Any, raster: Raster, out: Any) -> None:
    coords, size, pixels = new_sample_coords(), record_size(alpha), raster.height * raster.stride
    below = row_below(raster, size)
    for y in range(raster.height):
        for x0 in range(0, raster.stride, LANES):
            x = min(x0, raster.stride - LANES)
            pixel = y * raster.stride + x
            prefetch_rows(picture, out, x, y, 7, raster, size)
            locate(coords, 5 * LANES, (load(dx, pixel), load(dy, pixel)), x, y, raster, size, bilinear)
            color = sample(picture, below, coords, 5 * LANES, bilinear, alpha)
            store(out, pixel, color.l)
            store(out, pixels + pixel, color.a)
            store(out, 2 * pixels + pixel, color.b)
            store(out, 3 * pixels + pixel, color.alpha)


def sampled(records: npt.NDArray[Any], dx: Any, dy: Any, sampling: str) -> npt.NDArray[np.float32]:
    """Return one sample of the records (H, W, 3 or 4) for each pixel, (dx, dy) away, (3 or 4, H, W)."""
    raster, size = raster_of(records), records.shape[2]
    picture = np.append(padded_rows(records, raster), [0, 0]).astype(np.float32)
    out = np.zeros((4, raster.height, raster.stride), np.float32)
    bilinear, alpha = True if sampling == "bilinear" else None, True if size == 4 else None
    _read(picture, padded_rows(dx, raster), padded_rows(dy, raster), bilinear, alpha, raster, out.reshape(-1))
    return out[:size, :, : raster.width]


@pytest.mark.parametrize("sampling", READ)
@pytest.mark.parametrize("shape", SHAPES)
def test_colours(shape: tuple[int, int], sampling: str) -> None:
    random = np.random.default_rng(3)
    colors, dx, dy = random.random((*shape, 3)), random.normal(0, 5, shape), random.normal(0, 5, shape)
    expected = np.moveaxis(READ[sampling](colors, dx, dy), -1, 0)
    np.testing.assert_allclose(sampled(colors, dx, dy, sampling), expected, rtol=0, atol=1e-6)


@pytest.mark.parametrize("sampling", READ)
@pytest.mark.parametrize("shape", SHAPES)
def test_colours_count_in_proportion_to_their_alpha(shape: tuple[int, int], sampling: str) -> None:
    random = np.random.default_rng(4)
    colors, alpha = random.random((*shape, 3)), random.random(shape) * (random.random(shape) > 0.3)
    dx, dy = random.normal(0, 5, (2, *shape))
    found = sampled(np.dstack([colors, alpha]), dx, dy, sampling)
    covered = READ[sampling](alpha, dx, dy)
    weighted = np.moveaxis(READ[sampling](colors * alpha[..., None], dx, dy), -1, 0)
    np.testing.assert_allclose(found[3], covered, rtol=0, atol=1e-6)
    np.testing.assert_allclose(found[:3] * found[3], weighted, rtol=0, atol=1e-6)
    assert np.isfinite(found).all()
