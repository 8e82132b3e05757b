"""Images from arrays."""

from __future__ import annotations

import numpy as np
import pytest

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.image import Image

RANDOM = np.random.default_rng(3)


@pytest.mark.parametrize(
    ("shape", "type", "channels"),
    [
        ((2, 3), "mono", ("Y",)),
        ((2, 3, 1), "mono", ("Y",)),
        ((2, 3, 2), "flow", ("flow.x", "flow.y")),
        ((2, 3, 3), "color", ("R", "G", "B")),
        ((2, 3, 4), "color", ("R", "G", "B", "A")),
        ((2, 3, 5), "data", ("channel0", "channel1", "channel2", "channel3", "channel4")),
    ],
)
def test_the_type_of_an_array_follows_from_its_channels(
    shape: tuple[int, ...], type: str, channels: tuple[str, ...]
) -> None:
    array = RANDOM.random(shape)
    image = Image.from_array(array)
    assert (image.type, image.channels) == (type, channels)
    np.testing.assert_array_equal(image.pixels, array.reshape(2, 3, -1).astype(np.float32))


def test_names_that_no_type_has_make_data() -> None:
    image = Image.from_array(np.zeros((2, 3, 2)), channels=("u", "v"))
    assert (image.type, image.channels) == ("data", ("u", "v"))


def test_an_array_is_copied() -> None:
    array = np.zeros((2, 3, 3), np.float32)
    image = Image.from_array(array)
    array[:] = 1
    assert image.pixels.max() == 0


@pytest.mark.parametrize("array", [np.zeros(3), np.zeros((0, 3)), np.zeros((2, 2), complex), np.zeros((1, 2, 3, 4))])
def test_other_arrays_are_errors(array: np.ndarray) -> None:
    with pytest.raises(ArgumentError, match=r"expected numbers of shape \(H, W\)") as error:
        Image.from_array(array)
    assert error.value.parameter == "array"


def test_an_image_refuses_parts_that_do_not_fit() -> None:
    with pytest.raises(ArgumentError, match=r"a flow image has the channels flow\.x,flow\.y, not R,G,B"):
        Image.from_array(np.zeros((2, 3, 3)), type="flow", channels=("R", "G", "B"))
    with pytest.raises(ArgumentError, match="'colour' is not a port type") as error:
        Image.from_array(np.zeros((2, 3, 3)), type="colour")  # type: ignore[arg-type]
    assert "color" in str(error.value.hint)


STORED = np.array([[[0, 55, 255], [128, 200, 10]]])
LINEAR = np.where(STORED / 255 <= 0.04045, STORED / 255 / 12.92, ((STORED / 255 + 0.055) / 1.055) ** 2.4)


@pytest.mark.parametrize(
    "array",
    [
        STORED.astype(np.uint8),
        (STORED * 257).astype(np.uint16),
        (STORED * 257).astype(">u2"),
        STORED / 255,
        np.float32(STORED / 255),
    ],
    ids=["uint8", "uint16", "big-endian", "float64", "float32"],
)
@pytest.mark.parametrize("name", ["sRGB", "srgb_rec709_scene"])
def test_an_array_of_srgb_is_decoded(array: np.ndarray, name: str) -> None:
    image = Image.from_array(array, colorspace=name)
    np.testing.assert_allclose(image.pixels, LINEAR, atol=2e-6)
    assert (image.type, image.colorspace.name) == ("color", "lin_rec709")
    grey = Image.from_array(array[..., 0], colorspace=name)
    np.testing.assert_allclose(grey.pixels, LINEAR[..., :1], atol=2e-6)
    assert grey.type == "mono"


def test_alpha_of_an_encoding_is_straight_and_not_decoded() -> None:
    rgba = np.concatenate([STORED, np.full((1, 2, 1), 51)], axis=2).astype(np.uint8)
    image = Image.from_array(rgba, colorspace="sRGB")
    np.testing.assert_allclose(image.pixels[..., 3], 0.2, rtol=1e-6)
    np.testing.assert_allclose(image.pixels[..., :3], 0.2 * LINEAR, atol=2e-6)


def test_an_array_of_a_log_is_decoded() -> None:
    image = Image.from_array(np.full((2, 2, 3), 0.4135884), colorspace="ACEScct")
    np.testing.assert_allclose(image.pixels, 0.18, atol=1e-3)
    assert image.colorspace.name == "lin_ap1_scene"


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("space", ["lin_rec709", "lin_ap1_scene"])
def test_whole_numbers_are_no_light(dtype: type, space: str) -> None:
    white = np.iinfo(dtype).max
    for array in (np.full((2, 2, 3), white, dtype), np.full((2, 2, 4), white, dtype), np.full((2, 2), white, dtype)):
        with pytest.raises(ArgumentError, match=f'white at {white} .divide by {white}, or colorspace="sRGB"'):
            Image.from_array(array, colorspace=space)
    with pytest.raises(ArgumentError, match=f"divide by {white}.$"):
        Image.from_array(np.full((2, 2), white, dtype), type="matte")


def test_whole_numbers_that_are_no_picture_stay() -> None:
    for type in ("depth", "id", "data"):
        assert Image.from_array(np.full((2, 2), 200, np.uint8), type=type).pixels.max() == 200


def test_other_whole_numbers_have_no_white() -> None:
    with pytest.raises(ArgumentError, match="expected uint8, uint16 or floats of sRGB, found int64"):
        Image.from_array(STORED, colorspace="sRGB")


def test_what_is_said_of_whole_numbers_scales_them() -> None:
    codes = STORED.astype(np.uint8)
    light = Image.from_array(codes, encoding="linear").pixels
    np.testing.assert_allclose(light, STORED / 255, rtol=1e-6)
    np.testing.assert_array_equal(
        Image.from_array(codes, encoding="sRGB").pixels, Image.from_array(codes, "sRGB").pixels
    )
    with pytest.raises(ArgumentError, match="expected uint8, uint16 or floats of linear, found int64"):
        Image.from_array(STORED, encoding="linear")


def test_an_encoding_is_decoded_to_the_space_that_is_asked_for() -> None:
    log = np.full((2, 2, 3), 0.4135884)
    own, asked = Image.from_array(log, encoding="ACEScct"), Image.from_array(log, "lin_rec709", encoding="ACEScct")
    assert (own.colorspace.name, asked.colorspace.name) == ("lin_ap1_scene", "lin_rec709")
    np.testing.assert_allclose(asked.pixels, 0.18, atol=1e-3)
    np.testing.assert_allclose(asked.to_array(encoding="ACEScct"), log, atol=1e-5)


def test_blue_green_red_is_found_by_name() -> None:
    codes = np.concatenate([STORED, np.full((1, 2, 1), 51)], axis=2).astype(np.uint8)
    image = Image.from_array(codes[..., [2, 1, 0, 3]], "sRGB", channels="BGRA")
    np.testing.assert_array_equal(image.pixels, Image.from_array(codes, "sRGB").pixels)
