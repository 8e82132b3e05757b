import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import blur, halo, rolling_guidance
from tests.filters.flows import THIN, cases
from tests.naive import rolling_guidance as naive


def close(smooth, expected):
    np.testing.assert_allclose(smooth, expected, rtol=0, atol=2e-3)


@pytest.mark.parametrize("parameters", [(2, 15, 3), (0.4, 40, 2), (4, 30, 1), (2, 1e6, 5)])
@pytest.mark.parametrize("name", ["photo", "noise"])
def test_equals_the_definition_in_float64(name, parameters):
    image, _ = cases()[name]
    smooth = rolling_guidance(image, *parameters)
    assert smooth.dtype == np.float32
    close(smooth, naive.rolling_guidance(image, *parameters))


@pytest.mark.parametrize("shape", THIN)
def test_thin_pictures_and_the_border_that_repeats(shape):
    image = np.random.default_rng(1).uniform(0, 100, (*shape, 3)).astype(np.float32)
    close(rolling_guidance(image, 3, 50, 2), naive.rolling_guidance(image, 3, 50, 2))


def test_pictures_wider_and_higher_than_a_block():
    image = np.random.default_rng(2).uniform(0, 100, (21, 1041, 3)).astype(np.float32)
    close(rolling_guidance(image, 1, 50, 1), naive.rolling_guidance(image, 1, 50, 1))


def test_the_first_guide_is_the_gaussian_blur():
    image, _ = cases()["photo"]
    close(rolling_guidance(image, 2, iterations=0), blur(image, 2))


def test_sigma_0_is_a_copy():
    image, _ = cases()["photo"]
    smooth = rolling_guidance(image, 0)
    np.testing.assert_array_equal(smooth, image)
    assert not np.shares_memory(smooth, image)


def grating(period):
    """Stripes of +-20 code values on the left of an edge of 60."""
    x = np.arange(160)
    row = np.where(x < 80, 90 + 20 * np.sign(np.sin(2 * np.pi * (x + 0.5) / period)), 160)
    return np.repeat(np.repeat(row[None, :, None], 40, 0), 3, 2).astype(np.float32)


def test_what_is_smaller_than_the_scale_goes_and_the_edge_beside_it_stays():
    smooth = rolling_guidance(grating(4), 2)[20, :, 0]
    assert np.ptp(smooth[10:70]) < 2  # the stripes, 40
    assert np.ptp(smooth[76:84]) > 60
    assert np.abs(np.diff(smooth[76:84])).max() > 30  # blurred by sigma 2 it is 14


def test_what_is_larger_than_the_scale_stays():
    image = grating(40)
    smooth = rolling_guidance(image, 2)
    assert np.abs(smooth - image)[:, 10:150].max() < 15
    assert np.abs(smooth - image).mean() < 0.5


def test_neighbours_are_weighted_by_alpha():
    image, _ = cases()["noise"]
    random = np.random.default_rng(4)
    alpha = random.random(image.shape[:2]).astype(np.float32)
    alpha[random.random(alpha.shape) < 0.3] = 0
    smooth = rolling_guidance(image, 2, 60, 3, alpha)
    close(smooth, naive.rolling_guidance(image, 2, 60, 3, alpha))
    np.testing.assert_array_equal(smooth[alpha == 0], image[alpha == 0])
    ones = np.ones(alpha.shape)
    np.testing.assert_array_equal(rolling_guidance(image, alpha=ones), rolling_guidance(image))


def test_the_colour_of_what_is_not_there_never_shows():
    image, _ = cases()["photo"]
    alpha = np.ones(image.shape[:2])
    alpha[:, 30:] = 0
    expected = rolling_guidance(image, alpha=alpha)
    for poison in (1e6, 1e34):
        poisoned = np.where(alpha[..., None] > 0, image, poison).astype(np.float32)
        smooth = rolling_guidance(poisoned, alpha=alpha)
        np.testing.assert_array_equal(smooth[:, :30], expected[:, :30])
        np.testing.assert_array_equal(smooth[:, 30:], poisoned[:, 30:])


@given(color=st.tuples(*[st.floats(-1e4, 1e4, width=32)] * 3), sigma=st.floats(0, 20), r=st.floats(1e-3, 1e300))
@settings(deadline=None, max_examples=30)
def test_constants_stay_exactly(color, sigma, r):
    image = np.full((6, 7, 3), color, np.float32)
    np.testing.assert_array_equal(rolling_guidance(image, sigma, r, 2), image)


def test_mirrored_and_shifted_pictures():
    image, _ = cases()["photo"]
    smooth = rolling_guidance(image)
    close(rolling_guidance(image[:, ::-1]), smooth[:, ::-1])
    close(rolling_guidance(image[::-1]), smooth[::-1])
    shifted = np.pad(image, ((0, 0), (5, 0), (0, 0)), "edge")
    np.testing.assert_allclose(rolling_guidance(shifted)[:, 40:], smooth[:, 35:], rtol=0, atol=1e-4)


def test_a_crop_with_its_halo_has_the_same_bits():
    image, _ = cases()["photo"]
    image = np.tile(image, (2, 2, 1))
    around = halo.rolling_guidance(1.5, 3)
    crop = rolling_guidance(image[7 : 57 + around, 13 : 70 + around], 1.5)
    np.testing.assert_array_equal(
        rolling_guidance(image, 1.5)[7 + around : 57, 13 + around : 70], crop[around:50, around:57]
    )


def test_every_number_of_threads_gives_the_same_bits(each_thread_count):
    image, _ = cases()["noise"]
    one, *others = each_thread_count(lambda: rolling_guidance(image, sigma_r=60))
    for other in others:
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("arguments", "parameter"),
    [
        ({"codes": np.zeros((4, 5))}, "codes"),
        ({"codes": np.full((4, 5, 3), np.nan)}, "codes"),
        ({"sigma_s": -1}, "sigma_s"),
        ({"sigma_s": 1001}, "sigma_s"),
        ({"sigma_r": 0}, "sigma_r"),
        ({"iterations": 1.0}, "iterations"),
        ({"alpha": np.ones((5, 4))}, "alpha"),
    ],
)
def test_errors_name_the_argument(arguments, parameter):
    with pytest.raises(ArgumentError, match=parameter) as error:
        rolling_guidance(**({"codes": np.zeros((4, 5, 3))} | arguments))
    assert error.value.parameter == parameter
