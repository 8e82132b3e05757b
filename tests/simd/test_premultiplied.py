import numpy as np
import pytest
from numba import njit

from flowabs_nodes.simd.lanes import LANES
from flowabs_nodes.simd.memory import load_triples, store_quads, store_triples
from flowabs_nodes.simd.premultiplied import load_rgb_over_ground, load_rgba, store_over

RGB = np.random.default_rng(0).random((LANES + 1, 3), np.float32)
ALPHA = np.linspace(0, 1, LANES + 1, dtype=np.float32)[:, None]  # 0 at the first pixel
RGBA = np.hstack([RGB * ALPHA, ALPHA])


@njit(error_model="numpy")
def _load(pixels, channels, i, out):
    store_quads(out, 0, load_rgba(pixels, channels, i))


@njit(error_model="numpy")
def _load_over(pixels, channels, ground, i, out):
    store_triples(out, 0, load_rgb_over_ground(pixels, channels, ground, i))


@njit(error_model="numpy")
def _store(rgb, under, pixels, i):
    store_over(load_triples(rgb, 3 * i), under, pixels, i)


def over(pixels, ground, i):
    """Return sixteen pixels from pixel i on, composited over a grey ground."""
    out = np.zeros((LANES, 3), np.float32)
    _load_over(pixels.reshape(-1), pixels.shape[1], ground, i, out.reshape(-1))
    return out


@pytest.mark.parametrize("i", [0, 1])
def test_a_picture_without_alpha_has_an_alpha_of_one(i):
    out = np.zeros((LANES, 4), np.float32)
    _load(RGBA.reshape(-1), 4, i, out.reshape(-1))
    np.testing.assert_array_equal(out, RGBA[i : i + LANES])
    _load(RGB.reshape(-1), 3, i, out.reshape(-1))
    np.testing.assert_array_equal(out, np.hstack([RGB, np.ones_like(ALPHA)])[i : i + LANES])


def test_colours_over_a_ground():
    expected = RGBA[:, :3] + (1 - ALPHA) * 0.25
    np.testing.assert_allclose(over(RGBA, 0.25, 0), expected[:LANES], rtol=1e-6)
    np.testing.assert_array_equal(over(RGB, 0.25, 1), RGB[1:])


def test_colours_without_premultiplication_are_zero_where_alpha_is():
    found = over(RGBA, -1.0, 0)
    np.testing.assert_array_equal(found[0], [0, 0, 0])
    np.testing.assert_allclose(found[1:], RGB[1:LANES], rtol=1e-6)


def test_what_alpha_is_too_small_to_divide_by_is_not_covered():
    pixels = RGBA.copy()
    pixels[:5] = [(4, 0.18, 1e-30, alpha) for alpha in (-1, -1e-45, 1e-45, 1e-38, 1e-20)]
    pixels[5] = (4, 0.18, 1e-30, 1.1e-20)
    found = over(pixels, -1.0, 0)
    np.testing.assert_array_equal(found[:5], 0)
    np.testing.assert_allclose(found[5], pixels[5, :3] / pixels[5, 3], rtol=1e-6)
    written = np.zeros_like(pixels)
    _store(RGB.reshape(-1), pixels.reshape(-1), written.reshape(-1), 0)
    np.testing.assert_array_equal(written[:5], pixels[:5])
    np.testing.assert_array_equal(written[5, :3], RGB[5] * pixels[5, 3])


def test_colours_get_the_alpha_of_the_picture_under_them():
    under, pixels = RGBA.copy(), np.full_like(RGBA, -1)
    under[0] = (0.5, 0.6, 0.7, 0)  # light without alpha, a glow
    _store(RGB.reshape(-1), under.reshape(-1), pixels.reshape(-1), 0)
    np.testing.assert_array_equal(pixels[0], under[0])
    np.testing.assert_array_equal(pixels[1:LANES], RGBA[1:LANES])
    np.testing.assert_array_equal(pixels[LANES:], -1)


def test_without_a_picture_under_them_colours_stay_three():
    pixels = np.zeros_like(RGB)
    _store(RGB.reshape(-1), np.zeros(0, np.float32), pixels.reshape(-1), 1)
    np.testing.assert_array_equal(pixels[1:], RGB[1:])
    np.testing.assert_array_equal(pixels[0], 0)
