"""Many walks at a time against the float64 reading of section 3.3: the same pixels, the same offsets."""

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
from tests.naive import walk as naive

Flow = npt.NDArray[np.float32]


@njit(error_model="numpy")
def _walk(flow: Any, frame: Raster, steps: int, pixel: Any, dx: Any, dy: Any) -> None:
    """Pixel and offset after each step, for both ways."""
    walks, pixels = new_streamlines(), frame.height * frame.stride
    for y in range(frame.height):
        for x0 in range(0, frame.stride, BATCH // 2):
            prefetch_tangents(flow, x0, y, steps, frame)
            start(walks, flow, x0, y, frame)
            for s in range(steps):
                for at in range(0, BATCH, LANES):
                    x, way = block_column(x0, at, frame), at // LANES % 2
                    advance(walks, at, x, y, frame)
                    to = (way * steps + s) * pixels + y * frame.stride + x
                    store(pixel, to, load(walks.pixel, at))
                    store(dx, to, load(walks.dx, at))
                    store(dy, to, load(walks.dy, at))
                turn(walks, flow)


def walked(flow: Flow, steps: int) -> list[npt.NDArray[Any]]:
    """(2 ways, steps, H, W) each."""
    frame = raster_of(flow)
    shape = (2, steps, frame.height, frame.stride)
    results = [np.zeros(shape, dtype) for dtype in (np.int32, np.float64, np.float64)]
    tangents = padded_rows(flow, frame).view(np.complex64)
    _walk(tangents, frame, steps, *(result.reshape(-1) for result in results))
    return [result[..., : frame.width] for result in results]


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
    "far too long": 1000 * random_flow((24, 35), seed=2),
    "narrow": random_flow((24, 5)),
    "a column": random_flow((24, 1)),
    "none": np.zeros((24, 35, 2), np.float32),
    **{f"{degrees} degrees": constant(degrees) for degrees in (0, 60, 45, 137)},
}


@pytest.mark.parametrize("name", FLOWS)
def test_walks_are_those_of_exact_arithmetic(name: str) -> None:
    flow, steps = FLOWS[name], 20
    frame = raster_of(flow)
    pixels, dxs, dys = walked(flow, steps)
    numbers = np.arange(frame.height * frame.stride, dtype=np.float64).reshape(frame.height, -1)[:, : frame.width]
    for way in range(2):
        for s, (dx, dy, _) in enumerate(naive.curve(flow, steps, 1 - 2 * way)):
            np.testing.assert_array_equal(pixels[way, s], naive.nearest(numbers, dx, dy))
            np.testing.assert_array_equal(dxs[way, s], dx)
            np.testing.assert_array_equal(dys[way, s], dy)


def test_at_right_angles_a_walk_does_not_turn_round() -> None:
    """Where rounding the products, or only one of them, would leave a little on one side or the other."""
    flow = np.zeros((3, 200, 2), np.float32)
    angle = np.random.default_rng(5).uniform(0, 2 * np.pi, 100)
    flow[:, ::2] = np.stack([np.cos(angle), np.sin(angle)], -1)
    flow[:, 1::2, 0], flow[:, 1::2, 1] = -flow[:, ::2, 1], flow[:, ::2, 0]
    pixels, _, _ = walked(flow, 3)
    numbers = np.arange(600.0).reshape(3, 200)
    for way in range(2):
        for s, (dx, dy, _) in enumerate(naive.curve(flow, 3, 1 - 2 * way)):
            np.testing.assert_array_equal(pixels[way, s], naive.nearest(numbers, dx, dy))
