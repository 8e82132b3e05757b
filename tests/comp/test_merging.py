"""Each merge operation against Nuke's formula in float64, for every pair of types."""

import numpy as np
import pytest

from flowabs_nodes.choices import MERGE_OPERATIONS
from flowabs_nodes.color.spaces import KNOWN, convert
from flowabs_nodes.comp.merging import BY_ALPHA, merged
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.image import Image
from tests.comp.pictures import noise, rgba
from tests.naive.merge import merge

CLOSE = {"rtol": 1e-6, "atol": 1e-6}


def matte(seed=3, height=5, width=7):
    return Image.from_array(np.random.default_rng(seed).random((height, width)), type="matte")


@pytest.mark.parametrize("operation", MERGE_OPERATIONS)
def test_pictures_with_alpha(operation):
    a, b = rgba(seed=1), rgba(seed=2)
    result = merged(Image.from_array(a), Image.from_array(b), operation)
    assert result.channels == ("R", "G", "B", "A")
    np.testing.assert_allclose(result.pixels, merge(operation, a, b, a[..., 3:], b[..., 3:]), **CLOSE)


@pytest.mark.parametrize("operation", MERGE_OPERATIONS)
def test_pictures_without_alpha_are_opaque(operation):
    a, b = noise(5, 7, 3, seed=1), noise(5, 7, 3, seed=2)
    result = merged(Image.from_array(a), Image.from_array(b), operation)
    assert result.channels == ("R", "G", "B")
    np.testing.assert_allclose(result.pixels, merge(operation, a, b, 1, 1), **CLOSE)


@pytest.mark.parametrize("operation", MERGE_OPERATIONS)
@pytest.mark.parametrize("with_alpha", ["A", "B"])
def test_a_missing_alpha_counts_as_1(operation, with_alpha):
    a, b = rgba(seed=1), rgba(seed=2)
    (b if with_alpha == "A" else a)[..., 3] = 1
    short_a = a if with_alpha == "A" else np.ascontiguousarray(a[..., :3])
    short_b = b if with_alpha == "B" else np.ascontiguousarray(b[..., :3])
    result = merged(Image.from_array(short_a), Image.from_array(short_b), operation)
    np.testing.assert_allclose(result.pixels, merge(operation, a, b, a[..., 3:], b[..., 3:]), **CLOSE)


@pytest.mark.parametrize("operation", MERGE_OPERATIONS)
def test_two_mattes_make_a_matte(operation):
    a, b = matte(1), matte(2)
    result = merged(a, b, operation)
    assert result.type == "matte"
    expected = np.clip(merge(operation, a.pixels, b.pixels, a.pixels, b.pixels), 0, 1)
    np.testing.assert_allclose(result.pixels, expected, **CLOSE)


@pytest.mark.parametrize("operation", MERGE_OPERATIONS)
def test_two_monos_keep_their_range(operation):
    a, b = (Image.from_array(noise(5, 7, seed=seed, low=-10, high=10)) for seed in (1, 2))
    result = merged(a, b, operation)
    assert result.type == "mono"
    np.testing.assert_allclose(result.pixels, merge(operation, a.pixels, b.pixels, 1, 1), **CLOSE)


@pytest.mark.parametrize("operation", MERGE_OPERATIONS)
@pytest.mark.parametrize("swapped", [False, True])
def test_a_matte_beside_a_picture(operation, swapped):
    """A grey picture, whose alpha is itself where the formula has an alpha, else 1."""
    grey, picture = matte(), rgba(seed=2)
    y = np.repeat(grey.pixels, 4, axis=2)
    if operation not in BY_ALPHA:
        y[..., 3] = 1
    a, b = (picture, y) if swapped else (y, picture)
    images = (Image.from_array(picture), grey) if swapped else (grey, Image.from_array(picture))
    result = merged(*images, operation)
    assert result.type == "color"
    np.testing.assert_allclose(result.pixels, merge(operation, a, b, a[..., 3:], b[..., 3:]), **CLOSE)


def test_lines_multiply_a_picture_without_a_hole_and_mask_one():
    lines, picture = Image.from_array(np.float32([[0, 0.5, 1]]), type="matte"), Image.from_array(np.ones((1, 3, 4)))
    np.testing.assert_array_equal(merged(lines, picture, "multiply").pixels[0, 0], [0, 0, 0, 1])
    np.testing.assert_array_equal(merged(lines, picture, "mask").pixels[0, 1], [0.5] * 4)


def test_ids_of_algebra():
    a, b = Image.from_array(rgba(seed=1)), Image.from_array(rgba(seed=2))
    np.testing.assert_array_equal(merged(a, b, "over").pixels, merged(b, a, "under").pixels)
    parts = merged(a, b, "mask").pixels + merged(a, b, "stencil").pixels
    np.testing.assert_allclose(parts, b.pixels, **CLOSE)
    np.testing.assert_array_equal(merged(a, a, "difference").pixels, 0 * a.pixels)
    clear = Image.from_array(np.zeros_like(a.pixels))
    np.testing.assert_array_equal(merged(clear, b, "over").pixels, b.pixels)


def test_a_comes_into_the_colour_space_of_b():
    a, b = noise(5, 7, 3, seed=1), noise(5, 7, 3, seed=2)
    result = merged(Image.from_array(a, "lin_ap1_scene"), Image.from_array(b), "plus")
    assert result.colorspace == KNOWN["lin_rec709"]
    expected = convert(a, KNOWN["lin_ap1_scene"], KNOWN["lin_rec709"]) + b
    np.testing.assert_allclose(result.pixels, expected, **CLOSE)


def test_a_picture_over_a_mono_is_in_the_pictures_space():
    mono, picture = Image.from_array(noise(5, 7)), Image.from_array(rgba(), "lin_ap1_scene")
    assert merged(picture, mono, "over").colorspace == KNOWN["lin_ap1_scene"]


def test_light_beyond_float32_is_refused():
    bright = Image.from_array(np.full((1, 2, 3), 1e30, np.float32))
    with pytest.raises(ArgumentError, match="multiply leaves float32 in 2 pixels, first at row 0, column 0"):
        merged(bright, bright, "multiply")
