"""Kodak's Cineon curve is colour-science's, by every name, and gives way to a config's own."""

import warnings

import numpy as np
import pytest

from flowabs_nodes import color
from flowabs_nodes.color import cineon

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import colour

REC709 = color.space("lin_rec709")
CODES = (np.arange(1024) / 1023).astype(np.float32)


def test_it_is_colour_sciences():
    expected = colour.models.log_decoding_Cineon(np.arange(1024) / 1023)
    np.testing.assert_allclose(cineon.linear(CODES), expected, rtol=2e-6, atol=2e-7)
    np.testing.assert_allclose(cineon.encoded(expected.astype(np.float32)), CODES, atol=3e-7)


def test_the_codes_that_everybody_knows():
    black, grey, white, last = cineon.linear(np.array([95, 470, 685, 1023], np.float32) / 1023)
    assert abs(black) < 1e-6
    assert grey == pytest.approx(0.18, abs=0.004)
    assert white == pytest.approx(1, abs=1e-6)
    assert last == pytest.approx(13.52, abs=0.01)


def test_there_and_back():
    light = np.concatenate([np.geomspace(1e-6, 13.5, 200), [-0.005, 0]]).astype(np.float32)
    np.testing.assert_allclose(cineon.linear(cineon.encoded(light)), light, rtol=5e-6, atol=2e-7)
    below = cineon.encoded(np.array([-0.1, -1, -10], np.float32))
    np.testing.assert_array_equal(below, below[0])
    assert abs(below[0]) < 1e-6, "nothing lies below code 0"


@pytest.mark.parametrize("name", ["cineon", "Cineon", "KodakLog"])
def test_by_name(name):
    pixels = np.repeat(CODES.reshape(1, -1, 1), 4, axis=2)
    linear, space = color.ocio.linearize(pixels, name)
    assert space == REC709
    np.testing.assert_array_equal(linear[0, :, 0], cineon.linear(CODES))
    np.testing.assert_array_equal(linear[..., 3], pixels[..., 3])
    np.testing.assert_allclose(color.ocio.encode_named(linear, space, name), pixels, atol=3e-7)


def test_a_configs_own_comes_first(tmp_path):
    config = tmp_path / "config.ocio"
    config.write_text(
        """ocio_profile_version: 2
roles: {default: lin_rec709_scene, scene_linear: lin_rec709_scene, aces_interchange: ACES2065-1}
file_rules: [!<Rule> {name: Default, colorspace: default}]
displays: {x: [!<View> {name: y, colorspace: lin_rec709_scene}]}
colorspaces:
  - !<ColorSpace> {name: ACES2065-1}
  - !<ColorSpace> {name: lin_rec709_scene}
  - !<ColorSpace>
    name: Cineon
    to_scene_reference: !<ExponentTransform> {value: [2, 2, 2, 1]}
"""
    )
    half = np.full((1, 1, 3), 0.5, np.float32)
    np.testing.assert_allclose(color.ocio.linearize(half, "cineon", str(config))[0], 0.25, atol=1e-4)
    np.testing.assert_array_equal(color.ocio.linearize(half, "kodaklog", str(config))[0], cineon.linear(half))
