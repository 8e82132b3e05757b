import numpy as np
import pytest

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import shoulder


def grey(*values):
    return np.repeat(np.float32(values)[None, :, None], 3, 2)


def naive(rgb, knee, headroom):
    """Return (H, W, 3) by the definition, in float64."""
    rgb = np.asarray(rgb, np.float64)
    m = rgb.max(-1, keepdims=True)
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        compressed = knee + headroom * (1 - np.exp(-(m - knee) / headroom))
        return np.where(m > knee, rgb * (compressed / m), rgb)


def test_known_values():
    light = shoulder(grey(0.18, 0.6, 1.0, 2.0, 100.0))[0, :, 0]
    expected = [0.18, 0.6, 0.6 + 0.4 * (1 - np.exp(-1)), 0.6 + 0.4 * (1 - np.exp(-3.5)), 1.0]
    np.testing.assert_allclose(light, expected, rtol=1e-6)


@pytest.mark.parametrize(("knee", "headroom"), [(0.6, 0.4), (0, 1), (0.9, 0.001), (4, 12), (0.1, 1e5)])
@pytest.mark.parametrize("size", [(1, 1), (3, 5), (23, 37)])
def test_equals_the_definition_in_float64(size, knee, headroom):
    random = np.random.default_rng(1)
    image = np.float32(random.normal(0.5, 1, (*size, 3)) * 10 ** random.uniform(-2, 3, (*size, 1)))
    result = shoulder(image, knee, headroom)
    assert result.dtype == np.float32
    np.testing.assert_allclose(result, naive(image, knee, headroom), rtol=2e-6, atol=1e-7)


def test_it_rises_everywhere_and_never_passes_its_limit():
    light = shoulder(grey(*np.linspace(0, 4, 4001)))[0, :, 0]
    assert (np.diff(light) > 0).all()
    assert light.max() < 1
    assert np.abs(np.diff(light, 2)).max() < 1e-5  # no kink: the slope at the knee is 1
    assert shoulder(grey(65504.0, 3e38)).max() <= 1.0000001


def test_what_is_not_above_the_knee_stays_bit_for_bit():
    image = np.random.default_rng(2).uniform(-2, 0.6, (20, 30, 3)).astype(np.float32)
    np.testing.assert_array_equal(shoulder(image), image)


def test_hue_stays_and_negative_channels_are_scaled_with_their_pixel():
    image = np.float32([[[2, 1, 0.5], [0.1, 8, -0.4], [-1, -2, 0.7]]])
    result = shoulder(image)
    np.testing.assert_allclose(result / result.max(-1, keepdims=True), image / image.max(-1, keepdims=True), rtol=1e-6)
    np.testing.assert_allclose(result, naive(image, 0.6, 0.4), rtol=1e-6)


def test_with_alpha_it_is_that_of_the_colour_behind_it():
    image = np.random.default_rng(3).uniform(0, 5, (12, 19, 3)).astype(np.float32)
    alpha = np.random.default_rng(4).uniform(0.1, 1, (12, 19, 1)).astype(np.float32)
    result = shoulder(np.concatenate([image * alpha, alpha], -1))
    np.testing.assert_array_equal(result[..., 3:], alpha)
    np.testing.assert_allclose(result[..., :3] / alpha, shoulder(image), rtol=2e-6)


def test_light_without_alpha_is_compressed_as_it_is():
    for alpha in (0, -1, 1e-30):
        result = shoulder(np.float32([[[2, 1, 0, alpha]]]))[0, 0]
        np.testing.assert_allclose(result[:3], shoulder(np.float32([[[2, 1, 0]]]))[0, 0], rtol=1e-6)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("channels", [3, 4])
def test_pixels_that_are_not_finite_are_refused_with_their_place(bad, channels):
    image = np.full((9, 21, channels), 0.5, np.float32)
    image[4, 17, 1] = bad
    with pytest.raises(ArgumentError, match=r"image: expected finite pixels, found 1 .* at x 17, y 4"):
        shoulder(image)


@pytest.mark.parametrize("value", [3e38, -3e38, 1e20, 1e-38, -1e-38])
def test_enormous_and_tiny_light_stays_finite(value):
    image = np.random.default_rng(5).uniform(0, 2, (5, 18, 4)).astype(np.float32)
    image[2, 3, :3], image[3, 3, 1], image[4, 5] = value, value, value
    assert np.isfinite(shoulder(image)).all()
    assert np.isfinite(shoulder(image, 0, 1e-30)).all()


@pytest.mark.parametrize(
    ("arguments", "parameter"),
    [
        ({"image": np.zeros((4, 5))}, "image"),
        ({"image": np.zeros((4, 5, 2))}, "image"),
        ({"knee": -1}, "knee"),
        ({"headroom": 0}, "headroom"),
    ],
)
def test_errors_name_the_argument(arguments, parameter):
    with pytest.raises(ArgumentError, match=parameter) as error:
        shoulder(**({"image": np.zeros((4, 5, 3))} | arguments))
    assert error.value.parameter == parameter


def test_every_number_of_threads_gives_the_same_bits(each_thread_count):
    image = np.random.default_rng(6).uniform(0, 3, (300, 400, 3)).astype(np.float32)
    one, *others = each_thread_count(lambda: shoulder(image))
    for other in others:
        np.testing.assert_array_equal(one, other)


def test_lift_is_added_times_alpha():
    image = np.float32(np.random.default_rng(2).uniform(-0.1, 3, (5, 7, 3)))
    np.testing.assert_allclose(shoulder(image, lift=0.02), shoulder(image) + np.float32(0.02), rtol=1e-6)
    alpha = np.float32([0, 0.25, 1, -1])[None, :, None]
    result = shoulder(np.concatenate([np.full((1, 4, 3), 0.1, np.float32), alpha], -1), lift=0.5)
    np.testing.assert_allclose(result[0, :, 0], [0.1, 0.225, 0.6, 0.1])
    np.testing.assert_array_equal(result[..., 3:], alpha)
    with pytest.raises(ArgumentError, match="lift"):
        shoulder(image, lift=-0.1)
