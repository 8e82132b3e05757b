"""Colours survive from file to file: what a file says of its colours is read, and is true of what is written."""

from __future__ import annotations

import zlib
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import OpenImageIO as oiio
import pytest

from flowabs_nodes.color import space, spaces
from flowabs_nodes.image import Image
from flowabs_nodes.io.read import read_image
from tests.color.profiles import curve, profile, table_profile
from tests.io.files import colors, exr, flat, planes, srgb_to_linear, written

CODES = np.linspace(20, 230, 24 * 32 * 3).reshape(24, 32, 3).astype(np.uint8)
AP0 = (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767)


def in_ap0(image: Image) -> np.ndarray:
    return spaces.convert(image.pixels[..., :3], image.colorspace, space("lin_ap0_scene"))


def with_profile(path: Path, icc: bytes, pixels: np.ndarray = CODES) -> Path:
    spec = oiio.ImageSpec(
        pixels.shape[1], pixels.shape[0], pixels.shape[2], "float" if pixels.dtype == np.float32 else str(pixels.dtype)
    )
    spec.attribute("oiio:ColorSpace", "unknown")
    spec.attribute("ICCProfile", oiio.TypeDesc(f"uint8[{len(icc)}]"), np.frombuffer(icc, np.uint8))
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec), output.geterror()
    output.write_image(pixels)
    output.close()
    return path


def png(path: Path, *chunks: tuple[bytes, bytes], pixels: np.ndarray = CODES) -> Path:
    """Write a PNG of 8 bits with these chunks before its pixels, and no other word on colour."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return len(data).to_bytes(4, "big") + name + data + zlib.crc32(name + data).to_bytes(4, "big")

    height, width, _ = pixels.shape
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    head = width.to_bytes(4, "big") + height.to_bytes(4, "big") + bytes([8, 2, 0, 0, 0])
    body = [chunk(b"IHDR", head), *(chunk(*each) for each in chunks), chunk(b"IDAT", zlib.compress(rows))]
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(body) + chunk(b"IEND", b""))
    return path


def chrm(*xy: float) -> tuple[bytes, bytes]:
    return b"cHRM", b"".join(round(x * 1e5).to_bytes(4, "big") for x in xy)


def gama(gamma: float) -> tuple[bytes, bytes]:
    return b"gAMA", round(1e5 / gamma).to_bytes(4, "big")


P3 = chrm(0.3127, 0.329, 0.68, 0.32, 0.265, 0.69, 0.15, 0.06)
REC709 = chrm(0.3127, 0.329, 0.64, 0.33, 0.3, 0.6, 0.15, 0.06)

PROFILES = {
    "adobe": (profile("Adobe RGB (1998)", curve(2.2)), "lin_adobergb_scene", lambda x: x ** (563 / 256)),
    "p3": (profile("P3-D65"), "lin_p3d65_scene", srgb_to_linear),
    "linear sRGB": (profile("sRGB", curve(1.0)), "lin_rec709", lambda x: x),
    "sRGB": (profile("sRGB"), "lin_rec709", srgb_to_linear),
    "gamma 1.8": (profile("sRGB", curve(1.8)), "lin_rec709", lambda x: x ** (461 / 256)),
    "rec2020": (profile("ITU-R BT.2020", curve(2.4)), "lin_rec2020_scene", lambda x: x ** (614 / 256)),
}


@pytest.mark.parametrize("suffix", [".png", ".tif", ".jpg"])
@pytest.mark.parametrize("name", PROFILES)
def test_profiles_are_read(tmp_path: Path, name: str, suffix: str) -> None:
    icc, space_name, linear = PROFILES[name]
    path = with_profile(tmp_path / f"a{suffix}", icc)
    image = read_image(path)
    codes = oiio.ImageInput.open(str(path)).read_image("uint8") / 255
    assert image.colorspace.name == space_name
    np.testing.assert_allclose(image.pixels, linear(codes), atol=2e-3)


@pytest.mark.parametrize("name", PROFILES)
def test_a_profile_of_a_float_tiff_is_read(tmp_path: Path, name: str) -> None:
    icc, space_name, linear = PROFILES[name]
    pixels = (CODES / 255).astype(np.float32)
    image = read_image(with_profile(tmp_path / "a.tif", icc, pixels))
    assert image.colorspace.name == space_name
    np.testing.assert_allclose(image.pixels, linear(pixels), atol=2e-3)
    out, _ = written(image, tmp_path / "out.tif")
    back = oiio.ImageInput.open(str(out))
    assert back.spec().format == oiio.TypeFloat
    np.testing.assert_allclose(back.read_image("float"), pixels, atol=1e-4)
    assert in_ap0(read_image(out)) == pytest.approx(in_ap0(image), abs=1e-4)


@pytest.mark.parametrize("suffix", [".png", ".tif", ".exr"])
@pytest.mark.parametrize("name", PROFILES)
def test_what_is_written_is_the_same_colour(tmp_path: Path, name: str, suffix: str) -> None:
    image = read_image(with_profile(tmp_path / "a.tif", PROFILES[name][0]))
    out, warned = written(image, tmp_path / f"out{suffix}")
    np.testing.assert_allclose(in_ap0(read_image(out)), in_ap0(image), atol=6e-3)
    assert not warned


def test_a_profile_that_cannot_be_read_is_told(tmp_path: Path) -> None:
    notes: list[str] = []
    read_image(with_profile(tmp_path / "a.tif", table_profile()), note=notes.append)
    assert "table of colours" in notes[0]
    assert "sRGB" in notes[0]


def test_grey_with_a_profile(tmp_path: Path) -> None:
    grey = with_profile(tmp_path / "a.tif", profile(curves=curve(1.8), kind=b"GRAY"), CODES[..., :1])
    image = read_image(grey)
    np.testing.assert_allclose(image.pixels[..., 1:2], (CODES[..., :1] / 255) ** (461 / 256), atol=1e-6)
    out, _ = written(image, tmp_path / "out.tif")  # red, green and blue: the profile is not true of them
    assert oiio.ImageInput.open(str(out)).spec().get_string_attribute("ICCProfile:color_space") == "RGB"
    np.testing.assert_allclose(in_ap0(read_image(out)), in_ap0(image), atol=6e-3)


@pytest.mark.parametrize(
    ("chunks", "space_name", "linear"),
    [
        ((gama(2.2), P3), "lin_p3d65_scene", lambda x: x**2.2),
        ((P3,), "lin_p3d65_scene", srgb_to_linear),
        ((gama(1.0), P3), "lin_p3d65_scene", lambda x: x),
        ((gama(2.2), REC709), "lin_rec709", lambda x: x**2.2),
        ((gama(1.8), REC709), "lin_rec709", lambda x: x**1.8),
        ((gama(1.0),), "lin_rec709", lambda x: x),
        (((b"sRGB", b"\0"), gama(2.2), P3), "lin_rec709", srgb_to_linear),
        (((b"cICP", bytes([12, 13, 0, 1])), gama(2.2), REC709), "lin_p3d65_scene", srgb_to_linear),
        (((b"cICP", bytes([1, 13, 0, 1])), P3), "lin_rec709", srgb_to_linear),
        (((b"cICP", bytes([9, 8, 0, 1])),), "lin_rec2020_scene", lambda x: x),
        ((), "lin_rec709", srgb_to_linear),
        ((chrm(*[0] * 8),), "lin_rec709", srgb_to_linear),
    ],
)
def test_what_a_png_says(tmp_path: Path, chunks: tuple[Any, ...], space_name: str, linear: Any) -> None:
    path = png(tmp_path / "a.png", *chunks)
    image = read_image(path)
    assert image.colorspace.name == space_name
    np.testing.assert_allclose(image.pixels, linear(CODES / 255), atol=5e-4)
    out, _ = written(image, tmp_path / "out.exr")
    np.testing.assert_allclose(in_ap0(read_image(out)), in_ap0(image), rtol=2e-3, atol=2e-3)


@pytest.mark.parametrize("codes", [(9, 16), (9, 18), (12, 16), (12, 13)])
def test_hdr_goes_back_into_a_png(tmp_path: Path, codes: tuple[int, int]) -> None:
    path = png(tmp_path / "a.png", (b"cICP", bytes([*codes, 0, 1])))
    image = read_image(path)
    out, warned = written(image, tmp_path / "out.png")
    spec = oiio.ImageInput.open(str(out))
    np.testing.assert_array_equal(spec.read_image("uint8"), CODES)
    assert tuple(spec.spec().getattribute("CICP")) == (*codes, 0, 1)
    assert not warned
    _, warned = written(image, tmp_path / "out.tif")
    assert bool(warned) == (codes[1] in (16, 18))  # what no ICC profile can say
    assert all("sRGB is written" in text for text in warned)


@pytest.mark.parametrize("name", ["ACEScg", "ARRI LogC4", "ACEScct", "lin_rec2020", "AdobeRGB", "sRGB"])
def test_an_exr_says_what_the_user_said(tmp_path: Path, name: str) -> None:
    pixels = np.full((4, 5, 3), 0.4, np.float32) + np.array([0, 0.1, -0.1], np.float32)
    for header in ({}, {"chromaticities": AP0}, {"colorInteropID": "lin_rec2020_scene"}):
        image = read_image(exr(tmp_path / "a.exr", planes(pixels), **header), colorspace=name)
        out, _ = written(image, tmp_path / "out.exr")
        back = read_image(out)
        assert back.colorspace == image.colorspace
        np.testing.assert_array_equal(back.pixels, image.pixels)


def test_a_header_that_says_the_same_stays(tmp_path: Path) -> None:
    plate = exr(tmp_path / "a.exr", planes(colors()), chromaticities=AP0)
    out, _ = written(read_image(plate, colorspace="ACES2065-1"), tmp_path / "out.exr")
    header = OpenEXR.File(str(out), header_only=True).header()
    assert header["chromaticities"] == pytest.approx(AP0, abs=1e-6)
    assert "colorInteropID" not in header


@pytest.mark.parametrize("suffix", [".png", ".tif"])
@pytest.mark.parametrize("given", ["AdobeRGB", "sRGB", "lin_rec709", "ACEScct", "srgb_p3d65_scene"])
def test_what_the_user_says_beats_the_profile(tmp_path: Path, given: str, suffix: str) -> None:
    for name in ("adobe", "linear sRGB", "p3"):
        image = read_image(with_profile(tmp_path / "a.tif", PROFILES[name][0], CODES // 2 + 60), colorspace=given)
        out, _ = written(image, tmp_path / f"out{suffix}")
        wanted = spaces.convert(image.pixels, image.colorspace, space("lin_rec709"))
        back = read_image(out)
        shown = spaces.convert(back.pixels, back.colorspace, space("lin_rec709"))
        inside = (wanted > 0.01) & (wanted < 1)
        np.testing.assert_allclose(shown[inside], wanted[inside], atol=0.02)


@pytest.mark.parametrize("suffix", [".png", ".tif"])
def test_what_a_format_cannot_say_is_told(tmp_path: Path, suffix: str) -> None:
    image = read_image(flat(tmp_path / "a.png", CODES))
    _, warned = written(image, tmp_path / f"out{suffix}", colorspace="ACEScct")
    assert "ACEScct" in warned[0]
    _, warned = written(image, tmp_path / f"out{suffix}", colorspace="sRGB")
    assert not warned


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64])
def test_floats_of_a_tiff_stay_floats(tmp_path: Path, dtype: Any) -> None:
    pixels = (colors() * 3 - 0.5).astype(dtype)
    spec = oiio.ImageSpec(32, 24, 3, {"float16": "half", "float32": "float", "float64": "double"}[str(np.dtype(dtype))])
    output = oiio.ImageOutput.create(str(tmp_path / "a.tif"))
    assert output.open(str(tmp_path / "a.tif"), spec)
    output.write_image(pixels)
    output.close()
    image = read_image(tmp_path / "a.tif")
    out, _ = written(image, tmp_path / "out.tif")
    back = oiio.ImageInput.open(str(out))
    assert back.spec().format == oiio.TypeFloat
    np.testing.assert_array_equal(back.read_image("float"), pixels.astype(np.float32))
    half = OpenEXR.File(str(written(image, tmp_path / "out.exr")[0])).channels()["RGB"].pixels
    np.testing.assert_allclose(half, pixels, rtol=1e-3)


@pytest.mark.parametrize("suffix", [".png", ".tif"])
@pytest.mark.parametrize(
    "name", ["AdobeRGB", "srgb_p3d65_scene", "g22_rec709_scene", "lin_rec709", "Gamma 2.2 Encoded AP1"]
)
def test_a_profile_is_made_for_what_a_file_could_not_say(tmp_path: Path, name: str, suffix: str) -> None:
    pixels = np.clip(colors() / 2.2, 0.05, 0.95)
    image = Image.from_array(pixels)
    out, warned = written(image, tmp_path / f"out{suffix}", colorspace=name, data_type="uint16")
    np.testing.assert_allclose(in_ap0(read_image(out)), in_ap0(image), atol=2e-3)
    assert not warned


@pytest.mark.parametrize("suffix", [".png", ".tif"])
@pytest.mark.parametrize("chunks", [(gama(2.2), P3), (P3,), (gama(1.8), REC709), ((b"cICP", bytes([12, 13, 0, 1])),)])
def test_wide_colours_of_a_png_are_not_cut(tmp_path: Path, chunks: tuple[Any, ...], suffix: str) -> None:
    pixels = np.full((4, 4, 3), (230, 20, 20), np.uint8)
    image = read_image(png(tmp_path / "a.png", *chunks, pixels=pixels))
    out, warned = written(image, tmp_path / f"out{suffix}")
    np.testing.assert_allclose(oiio.ImageInput.open(str(out)).read_image("uint8"), pixels, atol=1)
    np.testing.assert_allclose(in_ap0(read_image(out)), in_ap0(image), atol=6e-3)
    assert not warned
