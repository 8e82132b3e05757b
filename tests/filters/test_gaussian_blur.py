import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import blur
from tests.filters.pictures import noise, photo


def naive_blur(image, sigma):
    """Eq. 7 at whole steps, cut at ceil(3 sigma), border repeated, in float64."""
    steps = int(np.ceil(3 * sigma))
    offsets = np.arange(-steps, steps + 1)
    weights = np.exp(-(offsets**2) / (2 * sigma**2))
    weights /= weights.sum()
    result = np.asarray(image, np.float64)
    for axis in (0, 1):
        places = np.clip(np.arange(result.shape[axis])[:, None] + offsets, 0, result.shape[axis] - 1)
        result = np.moveaxis(np.tensordot(np.take(result, places, axis), weights, axes=(axis + 1, 0)), 0, 0)
    return result


@pytest.mark.parametrize("sigma", [0.3, 1.0, 2.5, 30.0])
@pytest.mark.parametrize("channels", [(), (1,), (3,), (4,)])
def test_equals_the_direct_sum(sigma, channels):
    image = np.random.default_rng(1).uniform(-100, 1e5, (13, 21, *channels)).astype(np.float32)
    blurred = blur(image, sigma)
    assert blurred.dtype == np.float32
    np.testing.assert_allclose(blurred, naive_blur(image, sigma), rtol=1e-6, atol=1e-6 * 1e5)


def test_point_becomes_the_kernel():
    point = np.zeros((9, 9), np.float32)
    point[4, 4] = 1
    blurred = blur(point, 1.0)
    assert blurred.sum() == pytest.approx(1)
    assert blurred[4, 5] / blurred[4, 4] == pytest.approx(np.exp(-0.5))
    assert blurred[4, 0] == 0  # beyond ceil(3 sigma)


def test_sigma_0_is_a_copy():
    image = photo()
    blurred = blur(image, 0)
    np.testing.assert_array_equal(blurred, image)
    assert not np.shares_memory(blurred, image)


@given(
    shape=st.sampled_from([(1, 1), (1, 7), (7, 1), (2, 3, 3), (1, 1, 4), (5, 4)]),
    value=st.floats(-1e30, 1e30),
    sigma=st.floats(0, 50),
)
@settings(deadline=None, max_examples=50)
def test_constant_stays(shape, value, sigma):
    np.testing.assert_allclose(blur(np.full(shape, value), sigma), np.float32(value), rtol=1e-6)


@pytest.mark.parametrize("axis", [0, 1])
def test_mirrored_picture_gives_mirrored_blur(axis):
    image = photo()
    np.testing.assert_allclose(blur(np.flip(image, axis), 2.0), np.flip(blur(image, 2.0), axis), rtol=1e-5)


def test_every_number_of_threads_gives_the_same_bits(each_thread_count):
    image = noise()
    one, *others = each_thread_count(lambda: blur(image, 2.0))
    for other in others:
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("image", "sigma", "parameter"),
    [
        (np.zeros(3), 1.0, "image"),
        (np.zeros((0, 3)), 1.0, "image"),
        (np.array([[1, np.nan]]), 1.0, "image"),
        (np.zeros((2, 2)), -1.0, "sigma"),
        (np.zeros((2, 2)), np.inf, "sigma"),
        (np.zeros((2, 2)), "wide", "sigma"),
    ],
)
def test_errors_name_the_argument(image, sigma, parameter):
    with pytest.raises(ArgumentError, match=parameter) as error:
        blur(image, sigma)
    assert error.value.parameter == parameter
