"""Ink by what it lies on: the node's picture, its ink alone, and the two together."""

import numpy as np
import pytest

from flowabs_nodes import color
from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.composite import COMPOSITE
from flowabs_nodes.nodes.declare import Context

TONED = {"ink_tone": 0.8, "light_below": 25.0}


def comp(image, lines, under=None, **params):
    """Return both outputs of the node."""
    inputs = {"image": image, "lines": Image.from_array(lines, type="matte")}
    if under is not None:
        inputs["under"] = under
    return call_node(COMPOSITE, Context(), inputs, params)


def scene(channels=3):
    """Return a picture of dark and light, and lines."""
    random = np.random.default_rng(0)
    pixels = random.uniform(0, 0.8, (20, 30, channels)).astype(np.float32)
    pixels[:10] *= 0.05
    if channels == 4:
        pixels[..., :3] *= pixels[..., 3:]
    return Image.from_array(pixels), random.random((20, 30), np.float32)


def test_off_by_default_and_then_the_same_bits():
    image, lines = scene()
    for space in ("linear", "lab"):
        plain, off = comp(image, lines, space=space), comp(image, lines, space=space, light_ink=(1, 0, 0))
        for name in plain:
            np.testing.assert_array_equal(plain[name].pixels, off[name].pixels)


@pytest.mark.parametrize("params", [{"ink_tone": 1.0}, {"light_below": 30.0}, TONED])
def test_ink_over_the_picture_is_the_picture_with_lines(params):
    image, lines = scene()
    result = comp(image, lines, opacity=0.7, **params)
    ink = result["ink"].pixels
    np.testing.assert_allclose(ink[..., 3], (1 - lines) * np.float32(0.7), rtol=1e-6)
    over = image.pixels * (1 - ink[..., 3:]) + ink[..., :3]
    np.testing.assert_allclose(result["image"].pixels, over, rtol=0, atol=1e-6)


def test_alpha_stays_and_ink_is_of_the_tone_of_the_colour_without_it():
    image, lines = scene(4)
    drawn = comp(image, lines, ink_tone=1.0)["image"].pixels
    k = (1 - lines)[..., None]
    np.testing.assert_array_equal(drawn[..., 3], image.pixels[..., 3])
    expected = image.pixels[..., :3] * (1 - k) + image.pixels[..., :3] / 8 * k
    np.testing.assert_allclose(drawn[..., :3], expected, rtol=0, atol=1e-4)


def test_dark_grounds_get_light_ink():
    pixels = np.full((4, 20, 3), 0.5, np.float32)
    pixels[:, :10] = 0.004
    result = comp(Image.from_array(pixels), np.zeros((4, 20), np.float32), light_below=20.0, light_ink=(0.9, 0.8, 0.7))
    drawn = result["image"].pixels
    np.testing.assert_allclose(drawn[:, :10], np.broadcast_to(np.float32((0.9, 0.8, 0.7)), (4, 10, 3)), atol=1e-6)
    np.testing.assert_allclose(drawn[:, 10:], 0, atol=1e-6)


def test_under_decides_instead_of_the_picture():
    image, lines = scene()
    under = Image.from_array(np.full((20, 30, 3), (0.8, 0.4, 0.2), np.float32))
    ink = comp(image, np.zeros_like(lines), under, ink_tone=1.0)["ink"].pixels
    np.testing.assert_allclose(ink[..., :3], np.broadcast_to(np.float32((0.1, 0.05, 0.025)), (20, 30, 3)), rtol=1e-3)


def test_under_of_another_colour_space_is_brought_to_the_pictures():
    image, lines = scene()
    wide = color.decode(image.encoded("lab"), "lab", "lin_ap1_scene")
    under = Image.from_array(wide, "lin_ap1_scene")
    one, other = (comp(image, lines, ground, **TONED)["image"].pixels for ground in (None, under))
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-4)


@pytest.mark.parametrize("space", ["lab", "acescct"])
def test_in_code_values_ink_covers_as_it_does_in_light(space):
    image, lines = scene()
    full = np.zeros_like(lines)
    one, other = (comp(image, full, space=mix, **TONED)["image"].pixels for mix in ("linear", space))
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-3)
