"""Images from arrays and ImageBufs, and back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.image import Image, Window
from flowabs_nodes.port_types import TYPES
from flowabs_nodes.testing.pictures import make_input

RANDOM = np.random.default_rng(3)


def buffer(names: tuple[str, ...]) -> oiio.ImageBuf:
    spec = oiio.ImageSpec(4, 3, len(names), oiio.FLOAT)
    spec.channelnames = names
    spec.x, spec.y, spec.full_x, spec.full_width = -2, 5, -4, 12
    spec.attribute("shot", "ab_010")
    buf = oiio.ImageBuf(spec)
    buf.set_pixels(buf.roi, RANDOM.random((3, 4, len(names)), np.float32))
    return buf


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


@pytest.mark.parametrize(
    ("names", "type", "channels"),
    [
        (("R", "G", "B"), "color", ("R", "G", "B")),
        (("A", "B", "G", "R"), "color", ("R", "G", "B", "A")),  # found by name, whatever their order
        (("flow.x", "flow.y"), "flow", ("flow.x", "flow.y")),
        (("Y",), "mono", ("Y",)),
        (("R", "G", "B", "Z"), "data", ("R", "G", "B", "Z")),
    ],
)
def test_the_type_of_a_buffer_follows_from_its_names(
    names: tuple[str, ...], type: str, channels: tuple[str, ...]
) -> None:
    buf = buffer(names)
    image = Image.from_imagebuf(buf)
    assert (image.type, image.channels) == (type, channels)
    picks = [names.index(name) for name in channels]
    np.testing.assert_array_equal(image.pixels, buf.get_pixels(oiio.FLOAT).reshape(3, 4, -1)[..., picks])


def test_a_type_takes_its_own_channels_of_a_layer() -> None:
    names = ("R", "G", "B", "diffuse.R", "diffuse.G", "diffuse.B", "Y")
    buf = buffer(names)
    pixels = buf.get_pixels(oiio.FLOAT).reshape(3, 4, -1)
    np.testing.assert_array_equal(Image.from_imagebuf(buf, type="color").pixels, pixels[..., :3])
    np.testing.assert_array_equal(Image.from_imagebuf(buf, type="color", layer="diffuse").pixels, pixels[..., 3:6])
    assert Image.from_imagebuf(buf, type="matte").type == "matte"
    with pytest.raises(ArgumentError, match=r"no channels flow\.x,flow\.y; the buffer has R,G,B,diffuse\.R"):
        Image.from_imagebuf(buf, type="flow")


def test_windows_and_metadata_go_both_ways() -> None:
    image = Image.from_imagebuf(buffer(("R", "G", "B")))
    assert image.data_window == Window(-2, 5, 4, 3)
    assert image.display_window == Window(-4, 0, 12, 3)
    back = image.to_imagebuf()
    np.testing.assert_array_equal(back.get_pixels(oiio.FLOAT).reshape(3, 4, 3), image.pixels)
    spec = back.spec()
    assert (spec.x, spec.y, spec.full_x, spec.full_width) == (-2, 5, -4, 12)
    assert spec.getattribute("shot") == "ab_010"
    assert spec.getattribute("oiio:ColorSpace") == "lin_rec709"


def test_a_buffer_without_flat_pixels_is_an_error(tmp_path: Path) -> None:
    missing = oiio.ImageBuf(str(tmp_path / "missing.exr"))
    spec = oiio.ImageSpec(4, 3, 2, oiio.FLOAT)
    spec.deep = True
    for buf in (missing, oiio.ImageBuf(spec), oiio.ImageBuf()):
        with pytest.raises(ArgumentError, match="an ImageBuf with flat pixels is expected") as error:
            Image.from_imagebuf(buf)
        assert error.value.parameter == "buf"


def test_on_another_window_pixels_are_cut_and_0_beyond() -> None:
    image = Image.from_imagebuf(buffer(("R", "G", "B")))
    moved = image.on_window(Window(-1, 4, 5, 3))
    assert moved.data_window == Window(-1, 4, 5, 3)
    expected = np.zeros((3, 5, 3), np.float32)
    expected[1:, :3] = image.pixels[:2, 1:]
    np.testing.assert_array_equal(moved.pixels, expected)
    assert image.on_window(Window(100, 100, 2, 2)).pixels.max() == 0
    assert image.on_window(image.data_window) is image


def test_an_image_refuses_parts_that_do_not_fit() -> None:
    with pytest.raises(ArgumentError, match=r"a flow image has the channels flow\.x,flow\.y, not R,G,B"):
        Image.from_array(np.zeros((2, 3, 3)), type="flow", channels=("R", "G", "B"))
    with pytest.raises(ArgumentError, match="'colour' is not a port type") as error:
        Image.from_array(np.zeros((2, 3, 3)), type="colour")  # type: ignore[arg-type]
    assert "color" in str(error.value.hint)


@pytest.mark.parametrize("kind", [name for name, declared in TYPES.items() if declared.channels and name != "matte"])
def test_the_channels_of_a_buffer_tell_its_type(kind: str) -> None:
    image = make_input(kind, "noise", 6, 8)
    again = Image.from_imagebuf(image.to_imagebuf())
    assert (again.type, again.channels) == (kind, image.channels)
    np.testing.assert_array_equal(again.pixels, image.pixels)


def test_a_channel_of_fractions_that_is_called_id_is_data() -> None:
    assert Image.from_imagebuf(buffer(("id",))).type == "data"
    with pytest.raises(ArgumentError, match="whole numbers"):
        Image.from_imagebuf(buffer(("id",)), type="id")


def test_whole_numbers_of_8_bits_are_ids_as_they_are() -> None:
    spec = oiio.ImageSpec(2, 1, 1, oiio.UINT8)
    spec.channelnames = ("id",)
    buf = oiio.ImageBuf(spec)
    buf.set_pixels(buf.roi, np.array([[[3], [255]]], np.uint8))
    np.testing.assert_array_equal(Image.from_imagebuf(buf).pixels.ravel(), [3, 255])


STORED = np.array([[[0, 55, 255], [128, 200, 10]]])
LINEAR = np.where(STORED / 255 <= 0.04045, STORED / 255 / 12.92, ((STORED / 255 + 0.055) / 1.055) ** 2.4)


@pytest.mark.parametrize(
    "array",
    [STORED.astype(np.uint8), (STORED * 257).astype(np.uint16), STORED / 255, np.float32(STORED / 255)],
    ids=["uint8", "uint16", "float64", "float32"],
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
