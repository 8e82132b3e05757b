"""Channels from anywhere: names of one image, of another, and numbers."""

import numpy as np
import pytest

from flowabs_nodes.comp.shuffling import shuffled, wrong_channels
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.image import Image
from tests.comp.pictures import noise, rgba


def test_without_channels_a_picture_stays():
    for pixels in (rgba(), noise(5, 7, 3)):
        result = shuffled(Image.from_array(pixels), None, {})
        np.testing.assert_array_equal(result.pixels, pixels)
        assert result.type == "color"


def test_names_and_numbers():
    pixels, other = rgba(), rgba(seed=9)
    channels = {"R": "G", "G": 0.5, "B": "other.R", "A": "other.A"}
    result = shuffled(Image.from_array(pixels), Image.from_array(other), channels).pixels
    for i, expected in enumerate((pixels[..., 1], 0.5, other[..., 0], other[..., 3])):
        np.testing.assert_array_equal(result[..., i], np.broadcast_to(expected, result.shape[:2]))


def test_data_has_the_channels_of_its_file():
    data = Image.from_array(noise(5, 7, 2, high=100.0), type="data", channels=("Z", "other.A"))
    result = shuffled(data, Image.from_array(rgba()), {"R": "Z", "G": "image.other.A", "A": "other.A"}).pixels
    np.testing.assert_array_equal(result[..., :2], data.pixels)
    assert (result[..., 2] == 0).all()
    np.testing.assert_array_equal(result[..., 3], rgba()[..., 3])


@pytest.mark.parametrize("kind", ["matte", "mono"])
def test_one_channel_is_grey_and_can_be_an_alpha(kind):
    grey = Image.from_array(np.random.default_rng(1).random((5, 7)), type=kind)
    result = shuffled(grey, None, {})
    assert result.channels == ("R", "G", "B")
    np.testing.assert_array_equal(result.pixels, np.repeat(grey.pixels, 3, axis=2))
    np.testing.assert_array_equal(
        shuffled(Image.from_array(rgba()), grey, {"A": "other.Y"}).pixels[..., 3:], grey.pixels
    )


@pytest.mark.parametrize(
    ("channels", "message", "hint"),
    [
        ({"R": "r"}, "no channel 'r' for R", "did you mean 'R'?"),
        ({"A": "other.A"}, "no channel 'other.A' for A", "connect the input other"),
    ],
)
def test_an_unknown_channel(channels, message, hint):
    with pytest.raises(ArgumentError, match=message) as failure:
        shuffled(Image.from_array(rgba()), None, channels)
    assert failure.value.hint == hint


@pytest.mark.parametrize("value", [None, [], "R", {"Z": "R"}, {"R": True}, {"R": None}, {"R": ""}, {"R": float("nan")}])
def test_what_is_no_dict_of_channels(value):
    assert wrong_channels(value).startswith("an object from R, G, B or A")


def test_what_is_one():
    assert wrong_channels({}) is None
    assert wrong_channels({"R": "Z", "G": 0, "B": 0.5, "A": "other.A"}) is None
