import numpy as np
import pytest

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import composite, ink_color
from tests.naive.fdog import smoothstep


@pytest.mark.parametrize("size", [(1, 1), (3, 5), (20, 40)])
def test_equals_the_definition(size):
    random = np.random.default_rng(0)
    rgb, lightness = random.normal(0.5, 1, (*size, 3)), random.uniform(0, 100, size)
    ink, light_ink = np.array((0.1, 0.0, 0.3)), np.array((0.9, 0.8, 2.0))
    dark = ink + 0.6 * (np.maximum(rgb, 0) / np.maximum(rgb.max(2, keepdims=True), 1) / 8 - ink)
    light = 1 - smoothstep(0.75, 1.25, lightness / 40)[..., None]
    found = ink_color(rgb, lightness, tuple(ink), 0.6, tuple(light_ink), 40)
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, dark + light * (light_ink - dark), rtol=1e-5, atol=1e-6)


def test_without_tone_and_dark_grounds_it_is_the_ink():
    rgb = np.random.default_rng(0).normal(0.5, 1, (4, 5, 3))
    np.testing.assert_array_equal(ink_color(rgb, rgb[..., 0], (0.25, 0.5, 1)), np.full((4, 5, 3), (0.25, 0.5, 1)))


def test_full_tone_is_darker_and_of_the_same_hue():
    rgb = np.random.default_rng(0).uniform(0, 1, (4, 5, 3)).astype(np.float32)
    np.testing.assert_array_equal(ink_color(rgb, rgb[..., 0], tone=1), rgb / 8)


def test_on_highlights_ink_is_as_on_white_of_their_hue():
    np.testing.assert_allclose(ink_color([[[50, 25, 5]]], [[300]], tone=1), [[[1 / 8, 1 / 16, 1 / 80]]], rtol=1e-6)


def test_composite_takes_a_colour_for_each_pixel():
    random = np.random.default_rng(0)
    rgb, lines, alpha = random.normal(1, 3, (5, 6, 3)), random.random((5, 6)), random.random((5, 6))
    inks = random.normal(1, 1, (5, 6, 3))
    k = ((1 - lines) * 0.7)[..., None]
    expected = rgb * (1 - k) + inks * alpha[..., None] * k
    np.testing.assert_allclose(composite(rgb, lines, inks, 0.7, alpha), expected, rtol=1e-5, atol=1e-5)
    one = np.full((5, 6, 3), (0.3, 0.1, 2.0), np.float32)
    np.testing.assert_array_equal(composite(rgb, lines, one), composite(rgb, lines, (0.3, 0.1, 2.0)))


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"rgb": np.zeros((4, 5))}, "rgb: expected shape"),
        ({"rgb": np.full((4, 5, 3), np.inf)}, "rgb: "),
        ({"lightness": np.zeros((5, 5))}, "lightness: expected the size of the picture, 5x4, found 5x5"),
        ({"ink": (0, 0)}, "ink: expected three numbers, found 2"),
        ({"light_ink": (0, 0, "white")}, "light_ink: expected a number"),
        ({"tone": 1.5}, "tone: expected a number at least 0 and at most 1"),
        ({"light_below": -1}, "light_below: expected a number at least 0"),
    ],
)
def test_errors(arguments, text):
    with pytest.raises(ArgumentError, match=text):
        ink_color(**({"rgb": np.zeros((4, 5, 3)), "lightness": np.zeros((4, 5))} | arguments))


@pytest.mark.parametrize("ink", [np.zeros((4, 6, 3)), np.full((4, 5, 3), np.nan), np.zeros((4, 5, 4))])
def test_colours_that_do_not_fit_are_refused(ink):
    with pytest.raises(ArgumentError, match="ink"):
        composite(np.zeros((4, 5, 3)), np.zeros((4, 5)), ink)
