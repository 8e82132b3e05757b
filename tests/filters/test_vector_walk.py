"""Sixteen walks at a time against the float64 reading of section 3.3: the same pixels, the same offsets."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from numba import njit

from flowabs_nodes.filters import vector_walk
from flowabs_nodes.filters.vector import store
from tests.filters.flows import cases, random_flow
from tests.naive import walk as naive

Flow = npt.NDArray[np.float32]


@njit(error_model="numpy")
def _walk(flow: Any, width: int, height: int, way: int, steps: int, pixel: Any, dx: Any, dy: Any) -> None:
    """Pixel and offset (modulo 8, in units of 2^-29) after each step."""
    for y in range(height):
        for x0 in range(0, width, 16):
            x = min(x0, width - 16)
            walk = vector_walk.start(flow, x, y, width, way)
            for s in range(steps):
                walk = vector_walk.step(walk, flow, width, height)
                at = (s * height + y) * width + x
                store(pixel, at, vector_walk.inside(walk.x, walk.y, width, height))
                store(dx, at, walk.dx)
                store(dy, at, walk.dy)


def walked(flow: Flow, way: int, steps: int) -> list[npt.NDArray[np.int32]]:
    height, width, _ = flow.shape
    results = [np.zeros((steps, height, width), np.int32) for _ in range(3)]
    _walk(flow.reshape(-1), width, height, way, steps, *(result.reshape(-1) for result in results))
    return results


def constant(degrees: float) -> Flow:
    tangent = [math.cos(math.radians(degrees)), math.sin(math.radians(degrees))]
    return np.broadcast_to(np.float32(tangent), (24, 35, 2)).copy()


def ties() -> Flow:
    """Tangents whose sums lie half way between pixels, again and again."""
    choices = np.float32([[0.5, 0.0], [1.0, 0.0], [0.5, 0.5], [0.0, -0.5], [-1.0, 0.5], [0.25, 0.75]])
    return choices[np.random.default_rng(3).integers(0, len(choices), (24, 35))]


FLOWS = {
    "photo": cases()["photo"][1],
    "random": random_flow((24, 35)),
    "ties": ties(),
    "longer": 1.9 * random_flow((24, 35), seed=1),
    "none": np.zeros((24, 35, 2), np.float32),
    **{f"{degrees} degrees": constant(degrees) for degrees in (0, 60, 45, 137)},
}


@pytest.mark.parametrize("name", FLOWS)
@pytest.mark.parametrize("way", [0, 1])
def test_walks_are_those_of_exact_arithmetic(name: str, way: int) -> None:
    flow, steps = FLOWS[name], 20
    pixels, dxs, dys = walked(flow, way, steps)
    numbers = np.arange(flow.shape[0] * flow.shape[1], dtype=np.float64).reshape(flow.shape[:2])
    for s, (dx, dy, _) in enumerate(naive.curve(flow, steps, 1 - 2 * way)):
        np.testing.assert_array_equal(pixels[s], naive.nearest(numbers, dx, dy))
        for found, expected in ((dxs[s], dx), (dys[s], dy)):
            off = (found / 2.0**29 - expected + 4) % 8 - 4
            assert abs(off).max() < 1e-7


def test_tangents_of_any_length_do_not_fit() -> None:
    flow = random_flow((20, 20))
    assert vector_walk.fits(flow)
    assert vector_walk.fits(-1.5 * flow)
    for axis in range(2):
        long = flow.copy()
        long[3, 4, axis] = -2
        assert not vector_walk.fits(long)
