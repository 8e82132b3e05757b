"""Streamlines against section 3.3 in float64: the same pixels, the same offsets."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from numba import njit

from flowabs_nodes.sampling.coords import Raster, padded_rows, raster_of
from flowabs_nodes.sampling.streamline import (
    BATCH,
    advance,
    block_column,
    new_streamlines,
    prefetch_tangents,
    start,
    turn,
)
from flowabs_nodes.simd.lanes import LANES
from flowabs_nodes.simd.memory import load, store
from tests.filters.flows import cases, random_flow
from tests.naive import streamline as naive

Flow = npt.NDArray[np.float32]


@njit(error_model="numpy")
def _follow(flow: Any, raster: Raster, steps: int, pixel: Any, dx: Any, dy: Any) -> None:
    """Write pixel and offset after each step, along and against the flow."""
    curves, pixels = new_streamlines(), raster.height * raster.stride
    for y in range(raster.height):
        for x0 in range(0, raster.stride, BATCH // 2):
            prefetch_tangents(flow, x0, y, steps, raster)
            start(curves, flow, x0, y, raster)
            for s in range(steps):
                for at in range(0, BATCH, LANES):
                    x, way = block_column(x0, at, raster), at // LANES % 2
                    advance(curves, at, x, y, raster)
                    to = (way * steps + s) * pixels + y * raster.stride + x
                    store(pixel, to, load(curves.pixel, at))
                    store(dx, to, load(curves.dx, at))
                    store(dy, to, load(curves.dy, at))
                turn(curves, flow)


def followed(flow: Flow, steps: int) -> list[npt.NDArray[Any]]:
    """Return pixel, dx and dy after each step, along and against the flow, (2, steps, H, W) each."""
    raster = raster_of(flow)
    shape = (2, steps, raster.height, raster.stride)
    results = [np.zeros(shape, dtype) for dtype in (np.int32, np.float64, np.float64)]
    tangents = padded_rows(flow, raster).view(np.complex64)
    _follow(tangents, raster, steps, *(result.reshape(-1) for result in results))
    return [result[..., : raster.width] for result in results]


def constant(degrees: float) -> Flow:
    tangent = [math.cos(math.radians(degrees)), math.sin(math.radians(degrees))]
    return np.broadcast_to(np.float32(tangent), (24, 35, 2)).copy()


def ties() -> Flow:
    """Return tangents whose sums often lie half way between pixels."""
    choices = np.float32([[0.5, 0.0], [1.0, 0.0], [0.5, 0.5], [0.0, -0.5], [-1.0, 0.5], [0.25, 0.75]])
    return choices[np.random.default_rng(3).integers(0, len(choices), (24, 35))]


FLOWS = {
    "photo": cases()["photo"][1],
    "random": random_flow((24, 35)),
    "ties": ties(),
    "longer": 1.9 * random_flow((24, 35), seed=1),
    "far too long": 1000 * random_flow((24, 35), seed=2),
    "narrow": random_flow((24, 5)),
    "a column": random_flow((24, 1)),
    "none": np.zeros((24, 35, 2), np.float32),
    **{f"{degrees} degrees": constant(degrees) for degrees in (0, 60, 45, 137)},
}


@pytest.mark.parametrize("name", FLOWS)
def test_streamlines_are_those_of_exact_arithmetic(name: str) -> None:
    flow, steps = FLOWS[name], 20
    raster = raster_of(flow)
    pixels, dxs, dys = followed(flow, steps)
    numbers = np.arange(raster.height * raster.stride, dtype=np.float64).reshape(raster.height, -1)[:, : raster.width]
    for way in range(2):
        for s, (dx, dy, _) in enumerate(naive.curve(flow, steps, 1 - 2 * way)):
            np.testing.assert_array_equal(pixels[way, s], naive.nearest(numbers, dx, dy))
            np.testing.assert_array_equal(dxs[way, s], dx)
            np.testing.assert_array_equal(dys[way, s], dy)


def test_at_right_angles_a_streamline_does_not_turn_round() -> None:
    """Where rounding the products, or only one of them, would leave a little on one side or the other."""
    flow = np.zeros((3, 200, 2), np.float32)
    angle = np.random.default_rng(5).uniform(0, 2 * np.pi, 100)
    flow[:, ::2] = np.stack([np.cos(angle), np.sin(angle)], -1)
    flow[:, 1::2, 0], flow[:, 1::2, 1] = -flow[:, ::2, 1], flow[:, ::2, 0]
    pixels, _, _ = followed(flow, 3)
    numbers = np.arange(600.0).reshape(3, 200)
    for way in range(2):
        for s, (dx, dy, _) in enumerate(naive.curve(flow, 3, 1 - 2 * way)):
            np.testing.assert_array_equal(pixels[way, s], naive.nearest(numbers, dx, dy))
