"""Images from ImageBufs, and back; pixels on other windows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes import color
from flowabs_nodes.color.encoding import Encoding
from flowabs_nodes.color.icc import with_profile
from flowabs_nodes.color.transfers import SRGB
from flowabs_nodes.errors import ArgumentError, ColorError
from flowabs_nodes.image import Image, Window
from flowabs_nodes.io.color_tags import set_profile
from flowabs_nodes.io.read import read_image
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


# ---------------------------------------------------------------------- encodings of ImageBufs


def saved(path: Path, codes: np.ndarray, data_type: str, **attributes: object) -> oiio.ImageBuf:
    """Write a picture with OpenImageIO and return an ImageBuf that reads it."""
    spec = oiio.ImageSpec(codes.shape[1], codes.shape[0], codes.shape[2], data_type)
    for name, value in attributes.items():
        spec.attribute(name.replace("__", ":"), value)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec)
    assert output.write_image(codes)
    assert output.close()
    return oiio.ImageBuf(str(path))


PHOTO = RANDOM.integers(1, 256, (6, 5, 4), np.uint8)
RGB8 = np.ascontiguousarray(PHOTO[..., :3])


def light(codes: np.ndarray) -> np.ndarray:
    """Return what sRGB codes are as linear light, by the equation."""
    unit = codes / np.iinfo(codes.dtype).max
    return np.where(unit <= 0.04045, unit / 12.92, ((unit + 0.055) / 1.055) ** 2.4)


@pytest.mark.parametrize(
    ("name", "data_type", "codes"),
    [
        ("a.png", "uint8", RGB8),
        ("a.png", "uint16", RGB8 * np.uint16(257)),
        ("a.tif", "uint8", RGB8),
        ("a.tif", "uint16", RGB8 * np.uint16(257)),
        ("grey.png", "uint8", RGB8[..., :1].copy()),
    ],
)
def test_a_photograph_in_a_buffer_is_decoded(tmp_path: Path, name: str, data_type: str, codes: np.ndarray) -> None:
    buf = saved(tmp_path / name, codes, data_type)
    image = Image.from_imagebuf(buf)
    np.testing.assert_allclose(image.pixels, light(codes), atol=2e-6)
    assert image.colorspace.name == "lin_rec709"
    np.testing.assert_array_equal(read_image(tmp_path / name).pixels[..., : codes.shape[2]], image.pixels)
    unit = codes / np.iinfo(codes.dtype).max
    np.testing.assert_allclose(Image.from_imagebuf(buf, "lin_rec709").pixels, unit, atol=1e-6)  # as the caller says


def test_a_jpeg_in_a_buffer_is_what_is_read_from_its_file(tmp_path: Path) -> None:
    smooth = np.ascontiguousarray(np.broadcast_to(np.arange(0, 256, 8, np.uint8)[None, :, None], (32, 32, 3)))
    buf = saved(tmp_path / "a.jpg", smooth, "uint8")
    found = Image.from_imagebuf(buf).pixels
    np.testing.assert_array_equal(found, read_image(tmp_path / "a.jpg").pixels)
    np.testing.assert_allclose(found, light(smooth), atol=0.03)


def test_an_exr_in_a_buffer_stays_light(tmp_path: Path) -> None:
    pixels = RANDOM.random((6, 5, 4), np.float32)
    buf = saved(tmp_path / "a.exr", pixels, "float")
    np.testing.assert_array_equal(Image.from_imagebuf(buf).pixels, pixels)


@pytest.mark.parametrize("straight", [False, True])
def test_alpha_of_a_buffer_is_obeyed(tmp_path: Path, straight: bool) -> None:
    saved(tmp_path / "a.png", PHOTO, "uint8", oiio__UnassociatedAlpha=1)
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", int(straight))
    buf = oiio.ImageBuf(str(tmp_path / "a.png"), 0, 0, config)
    assert (buf.spec().get_int_attribute("oiio:UnassociatedAlpha") == 1) is straight
    image = Image.from_imagebuf(buf)
    alpha = PHOTO[..., 3:] / 255
    np.testing.assert_allclose(image.pixels[..., 3:], alpha, atol=1e-6)
    strong = (alpha > 0.5)[..., 0]  # 8 bits of premultiplied codes hold little of the colours under a small alpha
    expected = light(RGB8) * alpha
    np.testing.assert_allclose(image.pixels[..., :3][strong], expected[strong], atol=1e-6 if straight else 0.02)
    assert image.spec.getattribute("oiio:UnassociatedAlpha") is None


def test_straight_light_is_multiplied_by_alpha() -> None:
    buf = buffer(("R", "G", "B", "A"))
    expected = buf.get_pixels(oiio.FLOAT).reshape(3, 4, 4)
    buf.specmod().attribute("oiio:UnassociatedAlpha", 1)
    image = Image.from_imagebuf(buf)
    np.testing.assert_allclose(image.pixels[..., :3], expected[..., :3] * expected[..., 3:], rtol=1e-6)
    assert Image.from_imagebuf(image.to_imagebuf()).pixels.tobytes() == image.pixels.tobytes()


def test_a_tag_or_the_caller_says_another_encoding() -> None:
    codes = np.full((3, 4, 3), 0.4135884, np.float32)
    buf = oiio.ImageBuf(codes)
    assert Image.from_imagebuf(buf).pixels[0, 0, 0] == codes[0, 0, 0]  # floats without a tag are light
    by_name = Image.from_imagebuf(buf, "ACEScct")
    buf.specmod().attribute("oiio:ColorSpace", "ACEScct")
    for image in (by_name, Image.from_imagebuf(buf)):
        np.testing.assert_allclose(image.pixels, 0.18, atol=1e-3)
        assert image.colorspace.name == "lin_ap1_scene"
    with pytest.raises(ColorError, match=r"no colour space 'ACEScc1'.*did you mean"):
        Image.from_imagebuf(buf, "ACEScc1")


def test_what_comes_of_image_buf_algo_is_decoded_too(tmp_path: Path) -> None:
    buf = saved(tmp_path / "a.png", RGB8, "uint8")
    cut = oiio.ImageBufAlgo.cut(buf, oiio.ROI(1, 4, 2, 5))
    np.testing.assert_allclose(Image.from_imagebuf(cut).pixels, light(RGB8[2:5, 1:4]), atol=2e-6)
    as_float = oiio.ImageBufAlgo.copy(buf, oiio.FLOAT)
    np.testing.assert_allclose(Image.from_imagebuf(as_float).pixels, light(RGB8), atol=2e-6)
    linear = oiio.ImageBufAlgo.colorconvert(as_float, "sRGB", "lin_rec709")
    np.testing.assert_allclose(Image.from_imagebuf(linear).pixels, light(RGB8), atol=1e-4)
    crop = oiio.ImageBufAlgo.crop(buf, oiio.ROI(1, 4, 2, 5))
    image = Image.from_imagebuf(crop)
    assert (image.data_window, image.display_window) == (Window(1, 2, 3, 3), Window(0, 0, 5, 6))


def of_p3(path: Path) -> str:
    """Write a PNG whose profile says Display P3, and return its name."""
    spec = oiio.ImageSpec(5, 6, 3, "uint8")
    p3 = with_profile(Encoding("P3", color.space("lin_p3d65"), (SRGB, SRGB, SRGB)))
    assert p3 is not None
    set_profile(spec, p3.profile)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec)
    output.write_image(RGB8)
    output.close()
    return str(path)


def test_light_that_was_decoded_is_not_decoded_again(tmp_path: Path) -> None:
    saved(tmp_path / "a.png", RGB8, "uint8")
    for path, space in ((of_p3(tmp_path / "p3.png"), "lin_p3d65_scene"), (str(tmp_path / "a.png"), "lin_rec709")):
        for image in (Image.from_imagebuf(oiio.ImageBuf(path)), read_image(path)):
            assert image.colorspace.name == space
            np.testing.assert_allclose(image.pixels, light(RGB8), atol=1e-4)
            again = Image.from_imagebuf(image.to_imagebuf())
            assert again.colorspace == image.colorspace
            np.testing.assert_array_equal(again.pixels, image.pixels)
            matte = image.with_pixels(image.pixels[..., :1].copy(), "matte").to_imagebuf()
            np.testing.assert_array_equal(Image.from_imagebuf(matte).pixels, image.pixels[..., :1])


def test_what_was_converted_is_what_the_conversion_says_and_not_the_file(tmp_path: Path) -> None:
    p3 = oiio.ImageBufAlgo.copy(oiio.ImageBuf(of_p3(tmp_path / "p3.png")), oiio.FLOAT)
    assert Image.from_imagebuf(p3).colorspace.name == "lin_p3d65_scene"
    for name in ("lin_rec709", "ACEScct"):
        converted = oiio.ImageBufAlgo.colorconvert(p3, "sRGB", name)
        found = Image.from_imagebuf(converted).to_array(encoding="linear", colorspace="lin_rec709")
        np.testing.assert_allclose(found, light(RGB8), atol=2e-3)


def test_a_matte_and_data_in_a_photograph_are_not_decoded(tmp_path: Path) -> None:
    grey = saved(tmp_path / "grey.png", RGB8[..., :1].copy(), "uint8")
    np.testing.assert_allclose(Image.from_imagebuf(grey, type="matte").pixels, RGB8[..., :1] / 255, atol=1e-6)
    whole = saved(tmp_path / "a.png", RGB8, "uint8")
    np.testing.assert_allclose(Image.from_imagebuf(whole, type="data").pixels, RGB8 / 255, atol=1e-6)


def test_a_film_scan_in_a_buffer_is_what_is_read_from_its_file(tmp_path: Path) -> None:
    for transfer in ("", "Printing density", "Linear", "ITU-R 709-4"):
        attributes = {"dpx__Transfer": transfer} if transfer else {}
        path = tmp_path / "a.dpx"
        buf = saved(path, RGB8 * np.uint16(257), "uint16", **attributes)
        found, expected = Image.from_imagebuf(buf), read_image(path)
        np.testing.assert_array_equal(found.pixels, expected.pixels, transfer)
        oiio.ImageCache().invalidate(str(path))


def test_a_buffer_that_holds_nothing_says_why(tmp_path: Path) -> None:
    volume = oiio.ImageSpec(4, 3, 3, oiio.FLOAT)
    volume.depth = volume.full_depth = 2
    failed = oiio.ImageBufAlgo.resize(oiio.ImageBuf(), roi=oiio.ROI())
    for buf, found in (
        (oiio.ImageBuf(), "found an empty one"),
        (failed, "found .*[Uu]ninitialized"),
        (oiio.ImageBuf(str(tmp_path / "missing.exr")), "found Could not open file"),
        (oiio.ImageBuf(volume), "found a volume of 2 planes"),
        (np.zeros((2, 3, 3)), "found ndarray"),
    ):
        with pytest.raises(ArgumentError, match=f"an ImageBuf with flat pixels is expected, {found}") as error:
            Image.from_imagebuf(buf)
        assert error.value.parameter == "buf"
        assert "\n" not in str(error.value)
