"""Luminance and L* against colour-science."""

import warnings

import numpy as np
import pytest

from flowabs_nodes import color
from flowabs_nodes.errors import ArgumentError

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import colour

Y = np.concatenate([np.linspace(-0.5, 1, 500), np.geomspace(1, 1e5, 100), [0, 216 / 24389]])


def test_lstar_is_colour_sciences():
    np.testing.assert_allclose(color.lstar(Y), colour.colorimetry.lightness_CIE1976(Y * 100), rtol=1e-6, atol=2e-5)
    assert color.lstar([0, 1]).tolist() == [0, 100]
    assert color.lstar(Y).dtype == np.float32


def test_lstar_comes_back():
    np.testing.assert_allclose(color.lstar_inverse(color.lstar(Y)), Y, rtol=2e-6, atol=1e-9)
    tiny = np.float32([1e-30, -1e-30])
    np.testing.assert_allclose(color.lstar_inverse(color.lstar(tiny)), tiny, rtol=1e-6)


def test_lstar_is_the_code_values():
    rgb = np.random.default_rng(0).uniform(-0.2, 4, (20, 30, 3)).astype(np.float32)
    lstar = color.lstar(color.luminance(rgb, "lin_rec709"))
    np.testing.assert_allclose(color.encode_mono(rgb, "lab") / 2.55, lstar, rtol=1e-5, atol=2e-4)


def test_luminance():
    rgb = np.float32([[[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [0.3, 0.3, 0.3]]])
    expected = colour.RGB_COLOURSPACES["ITU-R BT.709"].matrix_RGB_to_XYZ[1]
    found = color.luminance(rgb, "lin_rec709")
    np.testing.assert_allclose(found[0, :3], expected, rtol=1e-6)
    assert found[0, 3:].tolist() == [1, np.float32(0.3)]
    assert color.luminance(rgb[0, 0], "ACEScg") == pytest.approx(0.2722287)


@pytest.mark.parametrize("value", [np.float32(1), np.zeros((4, 4)), np.zeros((4, 4, 4))])
def test_luminance_needs_three_channels(value):
    with pytest.raises(ArgumentError, match=r"\(H, W, 3\)"):
        color.luminance(value, "lin_rec709")
