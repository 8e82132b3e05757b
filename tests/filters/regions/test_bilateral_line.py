"""The bilateral filter over lines and parabolas: against the float64 reading in tests of the filters made of it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from flowabs_nodes.filters.regions.bilateral_line import line_pass
from flowabs_nodes.filters.regions.range_weights import smooth_by_passes
from flowabs_nodes.sampling.coords import raster_of
from tests.filters.flows import random_flow

RANDOM = np.random.default_rng(8)
CODES = RANDOM.uniform(0, 100, (13, 70, 3)).astype(np.float32)
FLOW = random_flow((13, 70))


def smoothed(flow: Any, across: bool, kappa: Any, sigma: float, bilinear: bool) -> Any:
    frame = raster_of(CODES)
    return smooth_by_passes(CODES, None, frame, [line_pass(flow, across, kappa, sigma, 50, bilinear, None, frame)], 1)


@pytest.mark.parametrize("bilinear", [False, True])
@pytest.mark.parametrize("sigma", [0.1, 1, 4 / 3, 5 / 3, 4])  # 1, 3, 4, 5 and 12 steps: one round of four, or more
def test_across_a_flow_is_along_the_one_at_right_angles(sigma: float, bilinear: bool) -> None:
    turned = np.stack([FLOW[..., 1], -FLOW[..., 0]], -1)
    across, along = smoothed(FLOW, True, None, sigma, bilinear), smoothed(turned, False, None, sigma, bilinear)
    np.testing.assert_array_equal(across, along)


@pytest.mark.parametrize("bilinear", [False, True])
def test_a_parabola_that_is_not_bent_is_a_line(bilinear: bool) -> None:
    straight = np.zeros(CODES.shape[:2])
    for sigma in (1, 3):
        np.testing.assert_allclose(
            smoothed(FLOW, False, straight, sigma, bilinear),
            smoothed(FLOW, False, None, sigma, bilinear),
            rtol=0,
            atol=1e-4,
        )


def test_a_parabola_bends_towards_its_normal() -> None:
    """Two to the right along t = (1, 0), 2^2 kappa / 2 down: n = (0, 1)."""
    flow = np.zeros_like(FLOW)
    flow[..., 0] = 1
    kappa = np.full(CODES.shape[:2], 0.5)
    spot = np.zeros_like(CODES)
    spot[6, 30] = 1
    frame = raster_of(spot)
    passed = smooth_by_passes(spot, None, frame, [line_pass(flow, False, kappa, 0.5, 50, False, None, frame)], 1)
    assert sorted(zip(*np.nonzero(passed[..., 0] > 0), strict=True)) == [(5, 28), (5, 32), (6, 29), (6, 30), (6, 31)]
