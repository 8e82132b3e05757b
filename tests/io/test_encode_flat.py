"""PNG and TIFF hold one picture to look at: encoded for the screen, cut to the display window."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes.errors import WriteError
from flowabs_nodes.image import Image, Window
from flowabs_nodes.io.read import read_data, read_image
from flowabs_nodes.io.write import build_picture, save, stored_key
from flowabs_nodes.testing.pictures import make_input
from tests.io.files import (
    colors,
    exr,
    flat,
    planes,
    windowed,
    written,
)


def codes(path: Path) -> np.ndarray:
    """Read a file's whole numbers, (H, W, C), alpha straight."""
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(str(path), config)
    pixels = source.read_image(source.spec().format)
    source.close()
    return np.asarray(pixels)


def spec(path: Path) -> oiio.ImageSpec:
    """Read a file's header."""
    return oiio.ImageInput.open(str(path)).spec()


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("suffix", [".png", ".tif"])
@pytest.mark.parametrize("channels", [3, 4])
def test_a_photograph_comes_back_code_for_code(tmp_path: Path, dtype: Any, suffix: str, channels: int) -> None:
    rng = np.random.default_rng(0)
    before = rng.integers(0, np.iinfo(dtype).max + 1, (20, 30, channels)).astype(dtype)
    if channels == 4:
        before[..., 3] = np.maximum(before[..., 3], np.iinfo(dtype).max // 2)
    plate = flat(tmp_path / f"plate{suffix}", before)
    out, warned = written(read_image(plate), tmp_path / f"out{suffix}")
    after = codes(out)
    assert after.dtype == dtype
    np.testing.assert_array_equal(after, before)
    assert not warned


def test_scene_linear_is_encoded_as_srgb(tmp_path: Path) -> None:
    pixels = np.array([[[0.0, 0.18, 1.0], [4.0, -1.0, 0.5]]], np.float32)
    out, _ = written(read_image(exr(tmp_path / "a.exr", planes(pixels))), tmp_path / "out.png")
    np.testing.assert_array_equal(codes(out), np.array([[[0, 118, 255], [255, 0, 188]]], np.uint8))
    assert spec(out).get_string_attribute("oiio:ColorSpace").startswith("srgb")


def test_another_space_goes_to_srgbs_primaries(tmp_path: Path) -> None:
    grey = np.full((4, 4, 3), 0.18, np.float32)
    image = read_image(exr(tmp_path / "a.exr", planes(grey), colorInteropID="lin_ap1_scene"))
    np.testing.assert_array_equal(codes(written(image, tmp_path / "out.png")[0]), 118)
    red = read_image(
        exr(tmp_path / "b.exr", planes(grey * np.array([1, 0, 0], np.float32)), colorInteropID="lin_ap1_scene")
    )
    assert (codes(written(red, tmp_path / "out.png")[0])[..., 0] > 118).all()


@pytest.mark.parametrize(
    ("suffix", "data_type", "expected"),
    [
        (".png", "auto", "uint8"),
        (".png", "uint16", "uint16"),
        (".tif", "auto", "uint16"),
        (".tif", "uint8", "uint8"),
        (".tif", "float", "float"),
        (".tiff", "auto", "uint16"),
    ],
)
def test_data_types(tmp_path: Path, suffix: str, data_type: str, expected: str) -> None:
    image = read_image(windowed(tmp_path / "plate.exr"))
    out, warned = written(image, tmp_path / f"out{suffix}", data_type=data_type)
    assert str(spec(out).format) == expected
    assert not warned


def test_data_types_that_do_not_fit_say_so(tmp_path: Path) -> None:
    image = read_image(windowed(tmp_path / "plate.exr"))
    for suffix, data_type in ((".png", "half"), (".png", "float"), (".tif", "half")):
        _, warned = written(image, tmp_path / f"out{suffix}", data_type=data_type)
        assert f"cannot hold {data_type}" in warned[0]


def test_float_tiff_is_scene_linear(tmp_path: Path) -> None:
    pixels = colors(channels=4).astype(np.float32) * 10
    out, _ = written(read_image(exr(tmp_path / "a.exr", planes(pixels))), tmp_path / "out.tif", data_type="float")
    np.testing.assert_array_equal(read_image(out).pixels, pixels)
    image = read_image(exr(tmp_path / "b.exr", planes(pixels), colorInteropID="lin_ap1_scene"))
    _, warned = written(image, tmp_path / "out.tif", data_type="float")
    assert "lin_ap1_scene" in warned[0]


@pytest.mark.parametrize("suffix", [".png", ".tif"])
def test_mattes_and_mono_are_never_colour_encoded(tmp_path: Path, suffix: str) -> None:
    image = read_image(windowed(tmp_path / "plate.exr"))
    ramp = np.linspace(0, 1, 24 * 32, dtype=np.float32).reshape(24, 32, 1)
    for kind in ("matte", "mono"):
        on_display = image.with_pixels(ramp, kind).on_window(image.display_window)  # type: ignore[arg-type]
        out, _ = written(image.with_pixels(ramp, kind), tmp_path / f"out{suffix}", data_type="uint16")  # type: ignore[arg-type]
        np.testing.assert_array_equal(codes(out), np.repeat(np.rint(on_display.pixels * 65535), 3, 2))


def test_the_display_window_is_what_is_seen(tmp_path: Path) -> None:
    plate = windowed(tmp_path / "plate.exr")  # data 32x24 from (3, -2), display 40x30 from (-5, 0)
    after = codes(written(read_image(plate), tmp_path / "out.png")[0])
    assert after.shape == (30, 40, 3)
    assert (after[22:] == 0).all()
    assert (after[:22, :8] == 0).all()
    assert (after[:22, 8:, 0] > 0).any()


def test_alpha_is_straight(tmp_path: Path) -> None:
    pixels = np.array([[[0.09, 0.09, 0.09, 0.5], [0.3, 0.2, 0.1, 0.0]]], np.float32)
    out, _ = written(read_image(exr(tmp_path / "a.exr", planes(pixels))), tmp_path / "out.png")
    np.testing.assert_array_equal(codes(out)[0, 0], [118, 118, 118, 128])
    assert codes(out)[0, 1, 3] == 0


def test_an_alpha_of_zero_everywhere_does_not_hide_the_picture(tmp_path: Path) -> None:
    pixels = colors(channels=4)
    pixels[..., 3] = 0
    out, _ = written(read_image(exr(tmp_path / "carrots.exr", planes(pixels))), tmp_path / "out.png")
    assert codes(out).shape[2] == 3


@pytest.mark.parametrize("suffix", [".png", ".tif"])
def test_stamps_and_metadata(tmp_path: Path, suffix: str) -> None:
    plate = flat(tmp_path / f"plate{suffix}", np.zeros((4, 4, 3), np.uint8), Copyright="me", ImageDescription="a cat")
    image = read_image(plate)
    out, _ = written(image, tmp_path / f"out{suffix}", metadata={"shot": "a01"})
    assert stored_key(out) == "the key"
    assert spec(out).get_string_attribute("Copyright") == "me"
    description = spec(out).get_string_attribute("ImageDescription")
    assert description.startswith("a cat")
    if suffix == ".tif":  # drops attributes that it does not know
        lines = description.split("\n")[1:]
        assert lines[:-1] == ["shot=a01", "flowabs:key=the key", 'flowabs:graph={"a": "é"}']
        assert re.fullmatch("flowabs:pixels=[0-9a-f]{40}", lines[-1])
    else:
        assert spec(out).get_string_attribute("shot") == "a01"
    again, _ = written(read_image(out), tmp_path / f"again{suffix}")
    assert spec(again).get_string_attribute("ImageDescription").count("flowabs:key") <= 1
    save(build_picture(read_image(out)), tmp_path / f"plain{suffix}")
    assert stored_key(tmp_path / f"plain{suffix}") is None


def test_what_does_not_fit(tmp_path: Path) -> None:
    image = read_image(windowed(tmp_path / "plate.exr"))
    _, warned = written(image, tmp_path / "out.png", layers={"ink": image}, keep_layers="*")
    assert "other layers are left out" in warned[0]
    flow = image.with_pixels(image.pixels[..., :2], "flow")
    for wrong in (flow, read_data(tmp_path / "plate.exr")):
        with pytest.raises(WriteError, match="write an EXR") as caught:
            written(wrong, tmp_path / "no.png")
        assert caught.value.code == "bad-format"
    assert not (tmp_path / "no.png").exists()


def test_a_huge_display_window_is_refused(tmp_path: Path) -> None:
    image = Image.from_array(colors())
    huge = image.spec
    huge.full_width = huge.full_height = 100_000
    with pytest.raises(WriteError, match="100000x100000"):
        written(Image(image.pixels, huge, "color"), tmp_path / "out.png")


def test_nan_is_not_written_silently(tmp_path: Path) -> None:
    pixels = np.array([[[np.nan, np.inf, -np.inf]]], np.float32)
    out, warned = written(Image.from_array(pixels), tmp_path / "out.png")
    np.testing.assert_array_equal(codes(out), [[[0, 255, 0]]])
    assert warned == ["image: 1 NaN written as 0"]


def test_windows_are_cut_like_images(tmp_path: Path) -> None:
    image = Image.from_array(colors()).on_window(Window(-2, -2, 10, 10))
    assert codes(written(image, tmp_path / "out.png")[0]).shape == (24, 32, 3)


@pytest.mark.parametrize("kind", ["flow", "depth", "normal", "motion", "id", "data"])
def test_what_is_no_picture_to_look_at_is_refused(tmp_path: Path, kind: str) -> None:
    with pytest.raises(WriteError, match=rf"PNG cannot hold an? {kind} image; write an EXR"):
        written(make_input(kind, "noise", 6, 8), tmp_path / "a.png")
