"""Exposure, quantise and shoulder, where light is below zero, next to nothing, or enormous."""

import numpy as np
import pytest

from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.filters import shoulder
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context
from flowabs_nodes.nodes.tone import EXPOSURE, QUANTIZE, SHOULDER


def result(node, pixels, **params):
    return call_node(node, Context(), {"image": Image.from_array(np.float32(pixels))}, params)["image"].pixels


@pytest.mark.parametrize("softness", [0.0, 0.7])
def test_a_ramp_through_black_never_turns_and_never_jumps_below(softness):
    """Hard steps go up only; nothing at or below L* 1 changes."""
    grey = np.linspace(-0.1, 0.1, 4001, dtype=np.float32)
    flat = result(QUANTIZE, np.repeat(grey[None, :, None], 3, 2), levels=10, softness=softness)[0, :, 0]
    still = grey <= 27 / 24389
    np.testing.assert_array_equal(flat[still], grey[still])
    assert (flat[grey > 0] > 0).all()
    assert np.abs(flat[grey < 0.0088] - grey[grey < 0.0088]).max() < 0.004


@pytest.mark.parametrize("sigma", [0.002, 0.005, 0.01, 0.02, 0.05])
@pytest.mark.parametrize("levels", [6, 8, 10, 14, 16])
def test_noise_about_black_grows_by_no_more_than_half(sigma, levels):
    noise = np.random.default_rng(0).normal(0.002, sigma, (200, 200, 3)).astype(np.float32)
    flat = result(QUANTIZE, noise, levels=levels, softness=0.7)
    assert flat.max() < 1.5 * noise.max()
    assert flat.min() > 1.5 * noise.min()


def test_exposure_below_zero():
    np.testing.assert_array_equal(result(EXPOSURE, [[[-1, 0, 2, 0.5]]], stops=1.0), [[[-2, 0, 4, 0.5]]])
    np.testing.assert_array_equal(result(EXPOSURE, [[[-3e38, 0, 2]]], stops=-1.0), np.float32([[[-1.5e38, 0, 1]]]))


@pytest.mark.parametrize("light", [2e38, -2e38])
def test_exposure_beyond_float32_is_refused(light):
    with pytest.raises(FlowabsError, match=r"stops: \+1 takes the picture's largest light, 2e\+38, beyond float32"):
        result(EXPOSURE, [[[1, 1, light]]], stops=1.0)


def test_the_shoulder_after_a_filter_and_under_alpha():
    """It sees what a filter's code values decode to; alpha and what is not covered stay."""
    pixels = np.random.default_rng(2).uniform(0, 3, (9, 20, 4)).astype(np.float32)
    pixels[..., 3] = 0.5
    pixels[:, :4] = 0
    image = Image.from_array(pixels)
    filtered = image.with_codes(image.encoded("lab"), "lab")
    plain, after = (call_node(SHOULDER, Context(), {"image": each}, {})["image"].pixels for each in (image, filtered))
    np.testing.assert_allclose(after, plain, rtol=1e-4, atol=1e-5)
    np.testing.assert_array_equal(plain[..., 3], pixels[..., 3])
    assert plain[..., :3].max() < 0.5
    assert not plain[:, :4].any()


def test_the_shoulder_after_a_filter_is_done_with_the_decoding():
    image = Image.from_array(np.random.default_rng(2).uniform(0, 3, (70, 20, 3)).astype(np.float32))
    filtered = image.with_codes(image.encoded("lab"), "lab")
    compressed = call_node(SHOULDER, Context(), {"image": filtered}, {"headroom": 1.0})["image"]
    assert compressed.deferred is not None
    np.testing.assert_array_equal(compressed.pixels, shoulder(filtered.pixels, headroom=1.0))


def test_a_shoulder_with_much_headroom_changes_next_to_nothing():
    pixels = np.random.default_rng(3).uniform(0, 1, (5, 16, 3)).astype(np.float32)
    np.testing.assert_allclose(result(SHOULDER, pixels, headroom=60000.0), pixels, rtol=1e-4)


def test_what_the_shoulder_cannot_compress_is_told_with_its_place():
    pixels = np.ones((9, 20, 3), np.float32)
    pixels[7, 5] = np.inf
    with pytest.raises(FlowabsError, match=r"image: expected finite pixels, found 3 .* at x 5, y 7"):
        result(SHOULDER, pixels)
