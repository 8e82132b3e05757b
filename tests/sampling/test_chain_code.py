"""Decoded chain codes against streamlines in float64: the same pixels."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from numba import njit

from flowabs_nodes.sampling.chain_code import MOST_STEPS, decode_offsets, encode_streamlines
from flowabs_nodes.sampling.coords import Raster, padded_rows, raster_of
from flowabs_nodes.simd.lanes import LANES
from flowabs_nodes.simd.memory import load, scratch, store
from tests.filters.flows import cases, random_flow
from tests.naive import streamline as naive

FLOWS = {
    "photo": cases()["photo"][1],
    "random": random_flow((20, 70)),
    "narrow": random_flow((9, 5)),
    "column": random_flow((30, 1)),
    "none": np.zeros((3, 17, 2), np.float32),
}


@njit
def _decode_all(chain: Any, steps: int, raster: Raster, size: int, out: Any) -> None:
    """Write the indices of all steps, along and against the flow, to ``out``: (steps, 2, H, stride), flattened."""
    kept, pixels = scratch(np.int32, 33), raster.height * raster.stride
    for y in range(raster.height):
        for x0 in range(0, raster.stride, LANES):
            x = min(x0, raster.stride - LANES)
            decode_offsets(chain, steps, x, y, raster, size, kept, LANES)
            for k in range(2 * steps):
                store(out, k * pixels + y * raster.stride + x, load(kept, (k + 1) * LANES))


def encoded(flow: npt.NDArray[np.float32], steps: int) -> npt.NDArray[np.int32] | None:
    raster = raster_of(flow)
    return encode_streamlines(padded_rows(flow, raster).view(np.complex64), steps, raster)


@pytest.mark.parametrize("steps", [1, 6, 8, 9, MOST_STEPS])
@pytest.mark.parametrize("name", FLOWS)
def test_chain_codes_lead_to_the_pixels_of_the_streamline(name: str, steps: int) -> None:
    flow, size = FLOWS[name], 3
    raster = raster_of(flow)
    places = np.zeros((steps, 2, raster.height, raster.stride), np.int32)
    chain = encoded(flow, steps)
    assert chain is not None
    _decode_all(chain, steps, raster, size, places.reshape(-1))
    numbers = size * np.arange(raster.height * raster.stride, dtype=np.float64).reshape(raster.height, raster.stride)
    for way in range(2):
        for s, (dx, dy, _) in enumerate(naive.curve(flow, steps, 1 - 2 * way)):
            expected = naive.nearest(numbers[:, : raster.width], dx, dy)
            np.testing.assert_array_equal(places[s, way, :, : raster.width], expected)


def test_only_moves_to_neighbours_and_not_too_many_fit() -> None:
    flow = random_flow((20, 30))
    assert encoded(flow, MOST_STEPS + 1) is None
    for axis in range(2):
        for length in (-1e30, -3.0, -2.0, 2.0, 3.0, 1e30):
            long = np.zeros((20, 30, 2), np.float32)
            long[10, 15, axis] = length
            assert encoded(long, 1) is None
            assert encoded(long, 6) is None


@pytest.mark.parametrize(("axis", "sign"), [(0, 1), (0, -1), (1, 1), (1, -1)])
def test_two_ties_in_a_row_move_by_two(axis: int, sign: int) -> None:
    """To 0.5, which is rounded to 0, in the row below, and on from there to 1.5, which is rounded to 2."""
    flow = np.zeros((30, 40, 2), np.float32)
    flow[..., axis] = sign
    assert encoded(flow, 3) is not None
    flow[15, 20, axis], flow[15, 20, 1 - axis] = 0.5 * sign, np.sqrt(0.75)
    assert encoded(flow, 1) is not None
    assert encoded(flow, 3) is None
