"""A plate or AOV that is read: pixels, windows, channels, alpha, colour space, limits."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import OpenImageIO as oiio
import pytest

from flowabs_nodes.errors import ColorError, CommandError, ReadError
from flowabs_nodes.image import Origin, Window
from flowabs_nodes.io.read import read_data, read_image
from flowabs_nodes.io.settings import Settings
from tests.io.files import (
    DATA,
    DISPLAY,
    box,
    colors,
    exr,
    flat,
    parts,
    planes,
    srgb_to_linear,
    windowed,
)

AP0 = (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767)


def test_pixels_and_windows(tmp_path: Path) -> None:
    path = windowed(tmp_path / "plate.exr")
    image = read_image(path)
    assert image.type == "color"
    assert image.data_window == Window(*DATA, 32, 24)
    assert image.display_window == Window(*DISPLAY)
    assert image.spec.format == oiio.TypeHalf
    assert image.origin == Origin(str(path), 0, "", ("R", "G", "B"))
    np.testing.assert_array_equal(image.pixels, colors().astype(np.float32))


def test_tiles_are_read(tmp_path: Path) -> None:
    pixels = colors(50, 70, 4)
    tiles = OpenEXR.TileDescription()
    tiles.xSize = tiles.ySize = 16
    path = exr(tmp_path / "tiled.exr", planes(pixels), type=OpenEXR.tiledimage, tiles=tiles)
    assert oiio.ImageInput.open(str(path)).spec().tile_width == 16
    np.testing.assert_array_equal(read_image(path).pixels, pixels.astype(np.float32))


def test_channels_are_found_by_name(tmp_path: Path) -> None:
    """Files hold channels in alphabetical order and OpenImageIO reorders them again."""
    pixels = colors(channels=4)
    channels = (
        planes(pixels)
        | planes(colors(seed=2), layer="diffuse")
        | {"Z": np.ones((24, 32), np.float32), "a.B": pixels[..., 0]}
    )
    path = exr(tmp_path / "layers.exr", channels)
    np.testing.assert_array_equal(read_image(path).pixels, pixels.astype(np.float32))
    np.testing.assert_array_equal(read_image(path, layer="diffuse").pixels, colors(seed=2).astype(np.float32))
    assert read_image(path, layer="diffuse").origin.layer == "diffuse"  # type: ignore[union-attr]


def test_scattered_channels(tmp_path: Path) -> None:
    red, green, blue = (np.full((4, 4), v, np.float16) for v in (1, 2, 3))
    other = np.zeros((4, 4), np.float16)
    path = exr(
        tmp_path / "s.exr", {"x.R": red, "x.G": green, "x.B": blue, "x.Bz": other, "x.Gz": other, "x.A": other + 0.5}
    )
    np.testing.assert_array_equal(read_image(path, layer="x").pixels[0, 0], [1, 2, 3, 0.5])


def test_parts(tmp_path: Path) -> None:
    small = {"dataWindow": box(2, 3, 16, 12), "displayWindow": box(*DISPLAY)}
    left = {"dataWindow": box(1, 1, 32, 24), "displayWindow": box(*DISPLAY)}
    path = parts(
        tmp_path / "parts.exr",
        ("depth", {"Z": np.ones((12, 16), np.float32)}, small),
        ("right", planes(colors(12, 16)), small),
        ("left", planes(colors(seed=5)), left),
    )
    assert read_image(path).data_window == Window(2, 3, 16, 12)
    image = read_image(path, part="left")
    assert image.data_window == Window(1, 1, 32, 24)
    assert image.origin is not None
    assert image.origin.part == 2
    np.testing.assert_array_equal(read_image(path, part=2).pixels, colors(seed=5).astype(np.float32))
    assert read_data(path, layer="depth").channels == ("Z",)


def test_grey_is_colour(tmp_path: Path) -> None:
    grey = colors()[..., :1]
    image = read_image(exr(tmp_path / "grey.exr", planes(grey, "Y")))
    assert image.channels == ("R", "G", "B")
    np.testing.assert_array_equal(image.pixels, np.repeat(grey.astype(np.float32), 3, 2))
    image = read_image(exr(tmp_path / "ya.exr", {"Y": grey[..., 0], "A": grey[..., 0] * 0 + np.float16(0.5)}))
    assert image.channels == ("R", "G", "B", "A")
    np.testing.assert_array_equal(image.pixels[..., 3], 0.5)


def test_mixed_data_types_take_the_wider(tmp_path: Path) -> None:
    channels: dict[str, Any] = planes(colors()) | {
        "A": np.full((24, 32), 0.1, np.float32),
        "id": np.zeros((24, 32), np.uint32),
    }
    image = read_image(exr(tmp_path / "mixed.exr", channels))
    assert image.spec.format == oiio.TypeFloat
    assert image.pixels[0, 0, 3] == np.float32(0.1)


def test_whole_numbers_stay_what_they_are(tmp_path: Path) -> None:
    """OpenImageIO makes 0..1 of them where they are read as float."""
    ids = np.arange(24 * 32, dtype=np.uint32).reshape(24, 32)
    channels: dict[str, Any] = planes(colors()) | {"id": ids, "id2.x": ids + 1, "Z": ids.astype(np.float32)}
    path = exr(tmp_path / "ids.exr", channels)
    warned: list[str] = []
    np.testing.assert_array_equal(read_data(path, layer="id", warn=warned.append).pixels[..., 0], ids)
    image = read_data(path)
    np.testing.assert_array_equal(image.pixels[..., image.channels.index("id2.x")], ids + 1)
    np.testing.assert_array_equal(image.pixels[..., image.channels.index("R")], colors()[..., 0].astype(np.float32))
    assert not warned
    read_data(exr(tmp_path / "big.exr", {"id": ids + 2**31}), warn=warned.append)
    assert "rounded" in warned[0]


def test_data_is_left_alone(tmp_path: Path) -> None:
    depth = np.ones((4, 5), np.float32)
    depth[0, 0], depth[1, 1], depth[2, 2] = np.inf, np.nan, -1e30
    notes: list[str] = []
    image = read_data(exr(tmp_path / "z.exr", {"Z": depth, "N.X": depth}), layer="Z", note=notes.append)
    assert image.type == "data"
    assert image.channels == ("Z",)
    np.testing.assert_array_equal(image.pixels[..., 0], depth)
    assert notes == ["1 NaN and 1 Inf in Z, left as they are"]


# ---------------------------------------------------------------------- alpha


def test_alpha_zero_everywhere_counts_as_opaque(tmp_path: Path) -> None:
    pixels = colors(channels=4)
    pixels[..., 3] = 0
    notes: list[str] = []
    path = exr(tmp_path / "carrots.exr", planes(pixels))
    image = read_image(path, note=notes.append)
    assert image.channels == ("R", "G", "B")
    assert image.alpha is None
    assert image.origin is not None
    assert image.origin.alpha == "A"
    assert "alpha is 0 in every pixel: the plate counts as opaque" in notes
    assert read_image(path, alpha="premultiplied").channels == ("R", "G", "B", "A")


def test_alpha_by_parameter(tmp_path: Path) -> None:
    pixels = colors(channels=4).astype(np.float32)
    path = exr(tmp_path / "a.exr", planes(pixels))
    np.testing.assert_array_equal(read_image(path).pixels, pixels)
    ignored = read_image(path, alpha="ignore")
    np.testing.assert_array_equal(ignored.pixels, pixels[..., :3])
    assert ignored.origin is not None
    assert ignored.origin.alpha == "A"
    straight = read_image(path, alpha="straight").pixels
    np.testing.assert_allclose(straight[..., :3], pixels[..., :3] * pixels[..., 3:], rtol=1e-6)
    np.testing.assert_array_equal(straight[..., 3], pixels[..., 3])


def test_a_pngs_straight_alpha_is_multiplied_in_linear_light(tmp_path: Path) -> None:
    """OpenImageIO would multiply the code values unless it is asked not to."""
    codes = np.array([[[255, 128, 0, 128], [200, 100, 50, 0], [10, 20, 30, 255]]], np.uint8)
    image = read_image(flat(tmp_path / "a.png", codes))
    alpha = codes[..., 3:] / 255
    expected = np.concatenate([srgb_to_linear(codes[..., :3] / 255) * alpha, alpha], axis=2)
    np.testing.assert_allclose(image.pixels, expected, atol=1e-6)
    assert "oiio:UnassociatedAlpha" not in {a.name for a in image.spec.extra_attribs}


def test_a_tiffs_premultiplied_alpha_is_divided_out_first(tmp_path: Path) -> None:
    codes = np.array([[[128, 64, 0, 128], [10, 20, 30, 255]]], np.uint8)
    image = read_image(flat(tmp_path / "a.tif", codes, oiio__UnassociatedAlpha=0))
    alpha = codes[..., 3:] / 255
    expected = np.concatenate([srgb_to_linear(codes[..., :3] / 255 / alpha) * alpha, alpha], axis=2)
    np.testing.assert_allclose(image.pixels, expected, atol=1e-6)


# ---------------------------------------------------------------------- colour


def test_photographs_are_linearised(tmp_path: Path) -> None:
    codes = (colors(dtype=np.float64) * 127).astype(np.uint8)
    for name, tolerance in (("a.png", 1e-6), ("a.tif", 1e-6), ("a.jpg", 0.1)):
        image = read_image(flat(tmp_path / name, codes))
        assert image.colorspace.name == "lin_rec709"
        assert image.spec.format == oiio.TypeUInt8
        assert np.abs(image.pixels - srgb_to_linear(codes / 255)).mean() < tolerance
    sixteen = read_image(flat(tmp_path / "b.png", codes.astype(np.uint16) * 257))
    assert sixteen.spec.format == oiio.TypeUInt16
    np.testing.assert_allclose(sixteen.pixels, srgb_to_linear(codes / 255), atol=1e-6)


def test_float_tiff_is_linear(tmp_path: Path) -> None:
    pixels = colors(dtype=np.float32) * 3
    image = read_image(flat(tmp_path / "a.tif", pixels))
    np.testing.assert_array_equal(image.pixels, pixels)


def test_where_the_colour_space_comes_from(tmp_path: Path) -> None:
    notes: list[str] = []
    path = exr(tmp_path / "ap0.exr", planes(colors()), chromaticities=AP0)
    assert read_image(path, note=notes.append).colorspace.name == "lin_ap0_scene"
    assert any("chromaticities" in text for text in notes)
    assert read_image(path, colorspace="ACEScg").colorspace.name == "lin_ap1_scene"
    path = exr(tmp_path / "tag.exr", planes(colors()), colorInteropID="lin_ap1_scene")
    assert read_image(path).colorspace.name == "lin_ap1_scene"
    with pytest.raises(ColorError) as caught:
        read_image(path, colorspace="nonsense")
    assert caught.value.file == str(path)


# ---------------------------------------------------------------------- limits and bad pixels


def test_non_finite_pixels(tmp_path: Path) -> None:
    pixels = np.full((6, 6, 3), 0.5, np.float16)
    pixels[2, 2], pixels[4, 4, 0] = np.nan, np.inf
    notes: list[str] = []
    path = exr(tmp_path / "nan.exr", planes(pixels))
    np.testing.assert_array_equal(read_image(path, note=notes.append).pixels, 0.5)
    assert "3 NaN and 1 Inf repaired from their neighbours" in notes
    with pytest.raises(ReadError, match="3 NaN and 1 Inf") as caught:
        read_image(path, nonfinite="error")
    assert caught.value.file == str(path)


def test_a_nan_is_repaired_before_colours_are_converted(tmp_path: Path) -> None:
    """A matrix would spread it over all channels: those of its pixel are what they are without it."""
    pixels = np.full((6, 6, 3), (0.5, 0.4, 0.3), np.float32)
    clean = read_image(exr(tmp_path / "clean.exr", planes(pixels)), colorspace="ARRI LogC4").pixels
    pixels[2, 3, 1] = np.nan
    found = read_image(exr(tmp_path / "nan.exr", planes(pixels)), colorspace="ARRI LogC4").pixels
    np.testing.assert_allclose(found, clean, rtol=1e-5)


def test_only_the_channels_that_are_read_are_looked_at(tmp_path: Path) -> None:
    depth = np.full((24, 32), np.inf, np.float32)
    path = exr(tmp_path / "z.exr", planes(colors()) | {"Z": depth})
    np.testing.assert_array_equal(read_image(path, nonfinite="error").pixels, colors())


def test_negative_and_very_bright_values_stay(tmp_path: Path) -> None:
    pixels = np.array([[[-1, 1e6, 3e38]]], np.float32)
    np.testing.assert_array_equal(read_image(exr(tmp_path / "hdr.exr", planes(pixels))).pixels, pixels)


@pytest.mark.parametrize("size", [(1, 1), (1, 50), (50, 1)])
def test_thin_plates(tmp_path: Path, size: tuple[int, int]) -> None:
    assert read_image(exr(tmp_path / "thin.exr", planes(colors(*size)))).pixels.shape == (*size, 3)


def test_root(tmp_path: Path) -> None:
    (tmp_path / "root").mkdir()
    path = windowed(tmp_path / "plate.exr")
    (tmp_path / "root" / "link.exr").symlink_to(path)
    with pytest.raises(CommandError, match="outside"):
        read_image(tmp_path / "root" / "link.exr", settings=Settings(root=tmp_path / "root"))
