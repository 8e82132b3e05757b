"""The rise of lightness that decides how hard a step is."""

import numpy as np
import pytest

from flowabs_nodes.filters.regions.rise import rise
from flowabs_nodes.simd.bands import limited
from tests.naive import quantize as naive

NOISE = np.random.default_rng(5).uniform(0, 100, (39, 35)).astype(np.float32)


@pytest.mark.parametrize("sigma", [0.3, 1.0, 2.4])
@pytest.mark.parametrize("shape", [(39, 35), (1, 1), (1, 20), (20, 1), (9, 5), (5, 15), (3, 16), (4, 17)])
def test_equals_the_definition(shape, sigma):
    picture = np.ascontiguousarray(NOISE[: shape[0], : shape[1]])
    np.testing.assert_allclose(rise(picture, sigma), naive.rises(picture, sigma), atol=2e-5)


def test_of_a_ramp_it_is_the_slope_times_the_length():
    ramp = np.repeat(0.25 * np.arange(60, dtype=np.float32)[None], 40, 0)
    np.testing.assert_allclose(rise(ramp, 2.0)[:, 8:-8], 0.5, rtol=1e-4)
    np.testing.assert_allclose(rise(ramp, 2.0, unit=1 / 2.55)[:, 8:-8], 0.5 / 2.55, rtol=1e-4)


def test_a_picture_twice_the_size_rises_as_much_over_twice_the_length():
    soft = 50 + 40 * np.tanh((np.arange(120, dtype=np.float32) - 60) / 8)
    small = np.repeat(soft[None, ::2], 20, 0)
    large = np.repeat(soft[None], 40, 0)
    np.testing.assert_allclose(rise(large, 4.0)[20, ::2], rise(small, 2.0)[10], atol=0.2)


def test_turned_pictures_have_turned_rises():
    expected = rise(NOISE, 1.3)
    np.testing.assert_allclose(rise(np.ascontiguousarray(NOISE.T), 1.3).T, expected, atol=2e-5)
    np.testing.assert_allclose(rise(np.ascontiguousarray(NOISE[::-1, ::-1]), 1.3)[::-1, ::-1], expected, atol=2e-5)


def test_any_number_of_threads_gives_the_same_bits():
    tall = np.tile(NOISE, (5, 2))
    with limited(1):
        expected = rise(tall, 1.7)
    for threads in (2, 3, 7):
        with limited(threads):
            np.testing.assert_array_equal(rise(tall, 1.7), expected)
