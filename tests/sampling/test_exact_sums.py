"""Eq. 6 of simple pictures, where the sum is known, and against float64."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from flowabs_nodes.sampling.exact_sums import exact_sum
from tests.filters.flows import random_flow
from tests.filters.pictures import noise
from tests.naive import fdog as naive
from tests.naive.streamline import along

ONE = np.ones(1)
TO_THE_RIGHT = np.broadcast_to(np.float32([1, 0]), (9, 20, 2))


def point() -> npt.NDArray[np.float32]:
    """Return a plane (1, 9, 20) of zeros with a 1 in row 4, column 10."""
    plane = np.zeros((1, 9, 20), np.float32)
    plane[0, 4, 10] = 1
    return plane


@pytest.mark.parametrize("sampling", ["bilinear", "nearest"])
def test_a_point_spreads_to_the_weights_of_both_axes(sampling: str) -> None:
    taps, weights = np.array([4.0, 2.0]), np.array([8.0, 3.0, 1.0])
    found = exact_sum(point(), TO_THE_RIGHT, taps, weights, sampling)[0]
    np.testing.assert_array_equal(found[3:6, 8:13], np.outer([2, 4, 2], [1, 3, 8, 3, 1]))
    assert found.sum() == 8 * 16


def test_with_one_weight_it_is_the_sum_over_the_gradient_line() -> None:
    image, flow = noise(), 3 * random_flow((60, 41))
    taps = naive.taps(1.0, 0.99)
    found = exact_sum(image[None], flow, taps[taps.size // 2 :], ONE, "bilinear")
    expected = naive.across(image.astype(float), flow.astype(float), taps)
    np.testing.assert_allclose(found[0], expected, rtol=0, atol=1e-4)


@pytest.mark.parametrize("sampling", ["bilinear", "nearest"])
def test_with_one_tap_it_is_the_sum_over_the_flow_axis(sampling: str) -> None:
    image, flow = noise(), 3 * random_flow((60, 41))
    weights = np.exp(-(np.arange(4) ** 2) / 2) / np.exp(-(np.arange(-3, 4) ** 2) / 2).sum()  # sigma 1
    found = exact_sum(image[None], flow, ONE, weights, sampling)
    np.testing.assert_allclose(found[0], along(image, flow, 1.0, sampling), rtol=0, atol=1e-4)


def test_each_of_four_planes_is_summed_by_itself() -> None:
    planes = np.stack([noise(seed=seed) for seed in range(4)])
    taps, weights, flow = np.array([1.0, 0.5]), np.array([1.0, 0.25]), random_flow((60, 41))
    together = exact_sum(planes, flow, taps, weights, "bilinear")
    for plane, found in zip(planes, together, strict=True):
        np.testing.assert_array_equal(exact_sum(plane[None], flow, taps, weights, "bilinear")[0], found)
