"""Grade and invert against the formulas in float64."""

import numpy as np
import pytest

from flowabs_nodes.color.spaces import KNOWN, normalised
from flowabs_nodes.comp.grading import graded, inverted
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.image import Image
from tests.comp.pictures import noise, rgba
from tests.naive.merge import grade

NEUTRAL = {"exposure": 0.0, "gain": 1.0, "offset": 0.0, "gamma": 1.0, "saturation": 1.0}
SETTINGS = [
    {"exposure": 1.5},
    {"exposure": -3.0, "gain": 2.5},
    {"offset": 0.2},
    {"offset": -0.1, "gain": 0.5},
    {"gamma": 2.2},
    {"gamma": 0.45, "offset": 0.05},
    {"saturation": 0.0},
    {"saturation": 2.0},
    {"exposure": 0.7, "gain": 1.2, "offset": 0.03, "gamma": 1.3, "saturation": 1.4},
]


@pytest.mark.parametrize("space", ["lin_rec709", "lin_ap1_scene"])
@pytest.mark.parametrize("settings", SETTINGS, ids=str)
def test_the_formula(settings, space):
    pixels = rgba()
    result = graded(Image.from_array(pixels, space), **NEUTRAL | settings)
    weights = normalised(KNOWN[space])[1]
    expected = grade(pixels[..., :3], pixels[..., 3:], **settings, weights=weights)
    np.testing.assert_allclose(result.pixels[..., :3], expected, rtol=2e-5, atol=2e-6)
    np.testing.assert_array_equal(result.pixels[..., 3], pixels[..., 3])


@pytest.mark.parametrize("settings", SETTINGS, ids=str)
def test_a_picture_without_alpha_is_opaque(settings):
    pixels = noise(5, 7, 3)
    opaque = np.concatenate([pixels, np.ones_like(pixels[..., :1])], axis=2)
    short, full = (graded(Image.from_array(each), **NEUTRAL | settings).pixels for each in (pixels, opaque))
    np.testing.assert_array_equal(short, full[..., :3])


def test_neutral_settings_change_no_bit():
    pixels = rgba()
    np.testing.assert_array_equal(graded(Image.from_array(pixels), **NEUTRAL).pixels, pixels)


def test_grading_commutes_with_premultiplication():
    """The grade of an element is the grade of its colours, times its alpha."""
    settings = NEUTRAL | SETTINGS[-1]
    colours, alpha = noise(5, 7, 3), np.float32(0.25)
    premultiplied = np.concatenate([colours * alpha, np.full_like(colours[..., :1], alpha)], axis=2)
    expected = graded(Image.from_array(colours), **settings).pixels * alpha
    result = graded(Image.from_array(premultiplied), **settings).pixels[..., :3]
    np.testing.assert_allclose(result, expected, rtol=1e-5, atol=1e-6)


def test_what_is_transparent_stays_black_and_a_glow_takes_gain_alone():
    pixels = np.float32([[[0, 0, 0, 0], [0.5, 0.5, 0.5, 0], [0.5, 0.5, 0.5, -1], [1, 1, 1, 1e-30]]])
    result = graded(Image.from_array(pixels), **NEUTRAL | {"gain": 2.0, "offset": 0.5, "gamma": 2.0}).pixels
    np.testing.assert_allclose(result[0, :, 0], [0, 1, 1, 2])


def test_gamma_leaves_what_is_below_zero():
    pixels = np.float32([[[-0.5, 0, 0.25]]])
    result = graded(Image.from_array(pixels), **NEUTRAL | {"gamma": 2.0}).pixels
    np.testing.assert_allclose(result, [[[-0.5, 0, 0.5]]], rtol=1e-6)


@pytest.mark.parametrize("settings", [{"exposure": 30.0, "gain": 1e6}, {"gamma": 0.05}], ids=str)
def test_light_beyond_float32_is_refused(settings):
    bright = Image.from_array(np.full((1, 1, 3), 1e30, np.float32))
    with pytest.raises(ArgumentError, match="grade leaves float32 in 1 pixels, first at row 0, column 0"):
        graded(bright, **NEUTRAL | settings)


# ---------------------------------------------------------------------- invert


def test_invert_of_one_channel_and_of_an_opaque_picture_is_1_minus_x():
    matte, rgb = np.random.default_rng(1).random((5, 7, 1), np.float32), noise(5, 7, 3)
    np.testing.assert_array_equal(inverted(Image.from_array(matte, type="matte"), "").pixels, 1 - matte)
    np.testing.assert_array_equal(inverted(Image.from_array(rgb), "").pixels, 1 - rgb)


def test_invert_stays_premultiplied_and_comes_back():
    pixels = rgba()
    image = Image.from_array(pixels)
    result = inverted(image, "").pixels
    np.testing.assert_allclose(result[..., :3], pixels[..., 3:] - pixels[..., :3], rtol=1e-6)
    np.testing.assert_array_equal(result[..., 3], pixels[..., 3])
    np.testing.assert_allclose(inverted(inverted(image, ""), "").pixels, pixels, atol=1e-6)


@pytest.mark.parametrize(("channels", "changed"), [("A", "A"), ("R", "R"), ("R, B", "RB"), ("*", "RGBA"), ("", "RGB")])
def test_channels_by_name(channels, changed):
    pixels = rgba()
    result = inverted(Image.from_array(pixels), channels).pixels
    for i, name in enumerate("RGBA"):
        white = 1 if name == "A" else pixels[..., 3]
        expected = white - pixels[..., i] if name in changed else pixels[..., i]
        np.testing.assert_allclose(result[..., i], expected, rtol=1e-6, atol=1e-7)


def test_an_unknown_channel_is_named_with_the_nearest():
    with pytest.raises(ArgumentError, match="no channel 'a'") as failure:
        inverted(Image.from_array(rgba()), "R,a")
    assert failure.value.hint == "did you mean 'A'?"
    assert failure.value.parameter == "channels"
