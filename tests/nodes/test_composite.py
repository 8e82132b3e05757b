"""Ink over light below zero and outside the gamut, in each space where ink can mix."""

import numpy as np
import pytest

from flowabs_nodes import color
from flowabs_nodes.choices import MIXING_SPACES
from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.composite import COMPOSITE
from flowabs_nodes.nodes.declare import Context

LIGHTLESS = [(0, 0, 0), (0.02, -0.05, 0.03), (-0.05, -0.05, -0.05), (-0.4, -0.15, 2.4), (-1.9, 0.4, -0.5), (-4, -3, -5)]
LINES = np.linspace(0, 1, 9, dtype=np.float32)


def comp(pixels, space, **params):
    """Return the pixels with lines from 0 to 1 along each row."""
    image = Image.from_array(np.float32(pixels))
    lines = Image.from_array(np.repeat(LINES[None], len(pixels), 0), type="matte")
    return call_node(COMPOSITE, Context(), {"image": image, "lines": lines}, {"space": space, **params})["image"].pixels


@pytest.mark.parametrize("space", MIXING_SPACES)
def test_a_pixel_without_luminance_is_only_scaled(space):
    rgb = np.repeat(np.float32(LIGHTLESS)[:, None], 9, 1)
    assert (color.luminance(rgb) <= 0).all()
    scaled = rgb * (1 - 0.8 * (1 - LINES))[None, :, None]
    np.testing.assert_allclose(comp(rgb, space, opacity=0.8), scaled, rtol=0, atol=1e-4)
    coloured = scaled + 0.8 * (1 - LINES)[None, :, None] * np.float32((0.3, 0.1, 0.2))
    np.testing.assert_allclose(comp(rgb, space, opacity=0.8, ink=(0.3, 0.1, 0.2)), coloured, rtol=0, atol=1e-4)


@pytest.mark.parametrize("space", MIXING_SPACES)
def test_and_so_under_alpha(space):
    rgba = np.repeat(np.float32([(*rgb, 1) for rgb in LIGHTLESS])[:, None] * 0.5, 9, 1)
    expected = rgba.copy()
    expected[..., :3] *= (1 - (1 - LINES))[None, :, None]
    np.testing.assert_allclose(comp(rgba, space), expected, rtol=0, atol=1e-4)


@pytest.mark.parametrize("space", MIXING_SPACES)
def test_black_ink_never_makes_a_picture_of_noise_brighter_or_more_negative(space):
    rgb = np.random.default_rng(0).normal(0.002, 0.01, (60, 9, 3)).astype(np.float32)
    inked = comp(rgb, space)
    lightless = color.luminance(rgb) <= 0
    assert (np.abs(inked[lightless]) <= np.abs(rgb[lightless]) + 1e-6).all()
    assert inked.max() <= rgb.max() + 1e-6
    assert inked.min() >= rgb.min() - 1e-6
