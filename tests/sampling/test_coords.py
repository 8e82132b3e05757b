"""Sample coordinates against NumPy: the nearest pixel and the four around, anywhere in and outside the picture."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from numba import njit

from flowabs_nodes.sampling.coords import Raster, bilinear_coords, nearest_pixels, padded_rows, raster_of
from flowabs_nodes.simd.lanes import LANES
from flowabs_nodes.simd.memory import load, store
from tests.naive.streamline import READ

SHAPES = [(9, 40), (1, 16), (6, 5), (5, 1), (1, 1)]


@njit(error_model="numpy")
def _find(dx: Any, dy: Any, raster: Raster, pixel: Any, corner: Any, fx: Any, fy: Any) -> None:
    for y in range(raster.height):
        for x0 in range(0, raster.stride, LANES):
            x = min(x0, raster.stride - LANES)
            at = y * raster.stride + x
            columns, rows = nearest_pixels(load(dx, at), load(dy, at), x, y, raster)
            store(pixel, at, rows * raster.stride + columns)
            found = bilinear_coords(load(dx, at), load(dy, at), x, y, raster)
            store(corner, at, found.y * raster.stride + found.x)
            store(fx, at, found.fx)
            store(fy, at, found.fy)


def offsets(shape: tuple[int, int]) -> list[npt.NDArray[np.float64]]:
    """Return random dx and dy, some near, some far and some half way between pixels."""
    random = np.random.default_rng(1)
    near = [random.normal(0, 3, shape), random.integers(-9, 9, shape) / 2, random.normal(0, 1000, shape)]
    return [np.choose(random.integers(0, 3, shape), near) for _ in range(2)]


@pytest.mark.parametrize("shape", SHAPES)
def test_points_are_read_as_in_float64(shape: tuple[int, int]) -> None:
    image, (dx, dy) = np.random.default_rng(2).random(shape), offsets(shape)
    raster = raster_of(image)
    inner = (raster.height, raster.stride)
    pixel, corner = np.zeros((2, *inner), np.int32)
    fx, fy = np.zeros((2, *inner), np.float32)
    _find(
        padded_rows(dx, raster),
        padded_rows(dy, raster),
        raster,
        *(each.reshape(-1) for each in (pixel, corner, fx, fy)),
    )
    picture = padded_rows(image, raster)

    def cut(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
        return array[:, : raster.width]

    np.testing.assert_array_equal(picture[cut(pixel)], READ["nearest"](image, dx, dy))
    right, below = int(raster.width > 1), raster.stride * (raster.height > 1)
    corner, fx, fy = cut(corner), cut(fx), cut(fy)
    assert corner.min() >= 0
    assert (corner % raster.stride <= max(raster.width - 2, 0)).all()
    upper = (1 - fx) * picture[corner] + fx * picture[corner + right]
    lower = (1 - fx) * picture[corner + below] + fx * picture[corner + below + right]
    np.testing.assert_allclose((1 - fy) * upper + fy * lower, READ["bilinear"](image, dx, dy), rtol=0, atol=1e-6)


def test_to_the_right_of_a_single_column_nothing_is_read() -> None:
    dx, dy = offsets((5, 1))
    raster = Raster(1, 5, LANES)
    numbers, fx, fy = np.zeros(5 * LANES, np.int32), *np.zeros((2, 5 * LANES), np.float32)
    _find(padded_rows(dx, raster), padded_rows(dy, raster), raster, numbers, numbers, fx, fy)
    assert (fx == 0).all()


def test_short_rows_are_filled_up_with_zeros() -> None:
    picture = np.ones((3, 5, 2), np.float32)
    raster = raster_of(picture)
    assert raster == Raster(5, 3, LANES)
    np.testing.assert_array_equal(padded_rows(picture, raster).reshape(3, LANES, 2).sum((0, 2)), [6] * 5 + [0] * 11)
    wide = np.ones((2, LANES))
    assert np.shares_memory(padded_rows(wide, raster_of(wide)), wide)
