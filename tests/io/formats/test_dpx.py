"""DPX: known codes in, scene-linear colour out; what the header says about the log, and what is assumed without it."""

from __future__ import annotations

import struct
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import OpenImageIO as oiio
import pytest

import flowabs_nodes as fa
from flowabs_nodes.color import cineon, srgb
from flowabs_nodes.errors import ReadError, WriteError
from flowabs_nodes.image import Window
from flowabs_nodes.io.read import read_data, read_image
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.io.write import build_picture, is_whole, save
from tests.engine.sequences import document
from tests.io.files import flat

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import colour

#: Places in the header (SMPTE 268M).
ORIENTATION, WIDTH, TRANSFER, TIMECODE = 768, 772, 801, 1920
PRINTING_DENSITY, LINEAR, LOGARITHMIC, ITU_R_709, Z_LINEAR, ADX = 1, 2, 3, 6, 11, 13


def codes(bits: int, channels: int = 3, height: int = 5, width: int = 8) -> np.ndarray:
    """(H, W, C) of whole numbers from 0 to the largest that so many bits hold."""
    values = np.linspace(0, 2**bits - 1, height * width * channels)
    return values.astype(np.int64).reshape(height, width, channels)


def dpx(path: Path, values: np.ndarray, bits: int, *patches: tuple[int, bytes], **attributes: Any) -> Path:
    """Write these codes, big endian unless asked; ``patches`` are (place, bytes) in the header.

    ``__`` in an attribute's name stands for ``:``.
    """
    spec = oiio.ImageSpec(values.shape[1], values.shape[0], values.shape[2], "uint8" if bits == 8 else "uint16")
    spec.attribute("oiio:BitsPerSample", bits)
    for name, value in {"oiio__Endian": "big", **attributes}.items():
        spec.attribute(name.replace("__", ":"), value)
    largest = 255 if bits == 8 else 65535
    pixels = np.rint(values * (largest / (2**bits - 1))).astype("uint8" if bits == 8 else "uint16")
    output = oiio.ImageOutput.create("dpx")
    assert output.open(str(path), spec), output.geterror()
    assert output.write_image(pixels), output.geterror()
    assert output.close()
    content = bytearray(path.read_bytes())
    for place, change in patches:
        content[place : place + len(change)] = change
    path.write_bytes(content)
    return path


def transfer(code: int) -> tuple[int, bytes]:
    return TRANSFER, bytes([code])


@pytest.mark.parametrize("bits", [8, 10, 12, 16])
@pytest.mark.parametrize("endian", ["big", "little"])
@pytest.mark.parametrize("width", [7, 8])
@pytest.mark.parametrize(("channels", "names"), [(1, "Y"), (3, "RGB"), (4, "RGBA")])
def test_every_depth_gives_its_codes(
    tmp_path: Path, bits: int, endian: str, width: int, channels: int, names: str
) -> None:
    """As data, codes are 0..1; OpenImageIO spreads 10 and 12 bits over 16, a tenth of a code at most."""
    values = codes(bits, channels, width=width)
    path = dpx(tmp_path / "a.dpx", values, bits, oiio__Endian=endian)
    assert path.read_bytes()[:4] == (b"SDPX" if endian == "big" else b"XPDS")
    if (bits, channels, width) == (10, 4, 7):  # OpenImageIO leaves the last alpha of each line undefined
        with pytest.raises(ReadError, match="lines of 7 pixels are not decoded right"):
            read_data(path)
        assert not is_whole(path)
        return
    assert is_whole(path)
    image = read_data(path)
    assert image.channels == tuple(names)
    np.testing.assert_allclose(image.pixels * (2**bits - 1), values, atol=0.1)


@pytest.mark.parametrize("bits", [10, 12, 16])
@pytest.mark.parametrize("code", [PRINTING_DENSITY, LOGARITHMIC])
def test_log_is_cineon(tmp_path: Path, bits: int, code: int) -> None:
    notes: list[str] = []
    image = read_image(dpx(tmp_path / "a.dpx", codes(bits), bits, transfer(code)), note=notes.append)
    assert image.type == "color"
    assert image.colorspace == fa.color.space("lin_rec709")
    expected = colour.models.log_decoding_Cineon(codes(bits) / (2**bits - 1))
    np.testing.assert_allclose(image.pixels, expected, rtol=3e-4, atol=1e-5)
    word = {PRINTING_DENSITY: "Printing density", LOGARITHMIC: "Logarithmic"}[code]
    assert notes == [f"colour space transfer characteristic {word}: cineon, brought to lin_rec709"]


def test_white_and_black_of_a_scan(tmp_path: Path) -> None:
    values = np.array([[[95, 95, 95], [685, 685, 685], [1023, 470, 0]]])
    image = read_image(dpx(tmp_path / "a.dpx", values, 10, transfer(LOGARITHMIC)))
    np.testing.assert_allclose(image.pixels[0], [[0, 0, 0], [1, 1, 1], [13.52, 0.1832, -0.0057]], rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize(
    ("bits", "said", "curve"),
    [
        (8, "8 bits are taken as: srgb_rec709_scene", srgb.linear),
        (10, "10 bits are taken as: cineon", cineon.linear),
        (12, "12 bits are taken as: cineon", cineon.linear),
        (16, "16 bits are taken as: cineon", cineon.linear),
    ],
)
@pytest.mark.parametrize("code", [0, 255])  # user defined; undefined
def test_untagged(tmp_path: Path, bits: int, said: str, curve: Any, code: int) -> None:
    notes: list[str] = []
    image = read_image(dpx(tmp_path / "a.dpx", codes(bits), bits, transfer(code)), note=notes.append)
    expected = curve((codes(bits) / (2**bits - 1)).astype(np.float32))
    np.testing.assert_allclose(image.pixels, expected, rtol=3e-4, atol=1e-5)
    assert notes == [f"colour space no transfer characteristic in the file, {said}, brought to lin_rec709"]


def test_other_transfer_characteristics(tmp_path: Path) -> None:
    values = codes(16)
    linear = values.astype(np.float32) / 65535

    def pixels(code: int) -> np.ndarray:
        return read_image(dpx(tmp_path / "a.dpx", values, 16, transfer(code))).pixels

    np.testing.assert_allclose(pixels(LINEAR), linear, atol=1e-7)
    np.testing.assert_allclose(pixels(Z_LINEAR), linear, atol=1e-7)
    np.testing.assert_allclose(pixels(ITU_R_709), srgb.linear(linear), atol=1e-6)
    adx, space = fa.color.ocio.linearize(linear, "ADX16")
    np.testing.assert_allclose(pixels(ADX), adx, rtol=1e-5, atol=1e-6)
    assert read_image(tmp_path / "a.dpx").colorspace == space


def test_the_parameter_comes_first(tmp_path: Path) -> None:
    """A camera's log in a file that says something else, against colour-science."""
    path = dpx(tmp_path / "a.dpx", codes(10), 10, transfer(PRINTING_DENSITY))
    notes: list[str] = []
    image = read_image(path, colorspace="arri_logc3_ei800", note=notes.append)
    assert notes[0].startswith("colour space given: arri_logc3_ei800")
    decoded = colour.models.log_decoding_ARRILogC3(codes(10) / 1023)
    camera = colour.RGB_COLOURSPACES["ARRI Wide Gamut 3"].matrix_RGB_to_XYZ
    expected = decoded @ camera.T
    back = image.pixels @ np.array(image.colorspace.to_xyz).reshape(3, 3).T
    grey = expected[..., 1] > 0.01
    np.testing.assert_allclose(back[..., 1][grey], expected[..., 1][grey], rtol=0.02)
    linear = read_image(path, colorspace="lin_ap1_scene")
    np.testing.assert_allclose(linear.pixels * 1023, codes(10), atol=0.1)
    assert linear.colorspace.name == "lin_ap1_scene"


@pytest.mark.parametrize("channels", [1, 4])
def test_grey_and_alpha(tmp_path: Path, channels: int) -> None:
    path = dpx(tmp_path / "a.dpx", codes(16, channels), 16, transfer(LINEAR))
    image = read_image(path)
    values = codes(16, channels) / 65535
    np.testing.assert_allclose(image.pixels, np.repeat(values, 3, 2) if channels == 1 else values, atol=1e-6)


def test_a_scan_from_bottom_to_top_is_turned_upright(tmp_path: Path) -> None:
    for code, upright in ((2, codes(16)[::-1]), (1, codes(16)[:, ::-1])):
        path = dpx(tmp_path / "a.dpx", codes(16), 16, transfer(LINEAR), (ORIENTATION, struct.pack(">H", code)))
        np.testing.assert_allclose(read_image(path).pixels * 65535, upright, atol=0.1)


def test_metadata_goes_on_and_how_codes_were_stored_does_not(tmp_path: Path) -> None:
    at = (TIMECODE, struct.pack(">I", 0x01020304))
    path = dpx(tmp_path / "a.dpx", codes(10), 10, at, dpx__SlateInfo="12A")
    image = read_image(path)
    save(build_picture(image), tmp_path / "out.exr")
    header = OpenEXR.File(str(tmp_path / "out.exr")).header()
    clock = header["timeCode"]
    assert (clock.hours, clock.minutes, clock.seconds, clock.frame) == (1, 2, 3, 4)
    assert header["dpx:SlateInfo"] == "12A"
    assert header["colorInteropID"] == "lin_rec709_scene"
    assert not {"dpx:Transfer", "dpx:Packing", "dpx:Version"} & header.keys()
    np.testing.assert_allclose(read_image(tmp_path / "out.exr").pixels, image.pixels, rtol=1e-3, atol=1e-5)


def test_a_log_plate_is_written_to_png_as_srgb(tmp_path: Path) -> None:
    """PNG is for looking at; it keeps the plate's sixteen bits."""
    path = dpx(tmp_path / "a.dpx", np.full((4, 4, 3), 685), 10, transfer(LOGARITHMIC))
    save(build_picture(read_image(path)), tmp_path / "out.png")
    source = oiio.ImageInput.open(str(tmp_path / "out.png"))
    assert source.spec().format == oiio.TypeUInt16
    assert source.read_image("uint16").min() >= 65534


def test_it_is_read_only(tmp_path: Path) -> None:
    image = read_image(dpx(tmp_path / "a.dpx", codes(10), 10))
    with pytest.raises(WriteError, match="DPX is read only; use exr, png, tif or tiff") as caught:
        save(build_picture(image), tmp_path / "b.dpx")
    assert caught.value.code == "bad-format"
    report = fa.run(document(), input=str(tmp_path / "a.dpx"), output=str(tmp_path / "b.exr"))
    assert report.exit_code == 0


# ---------------------------------------------------------------------- files that cannot be read


def test_content_must_be_a_dpx(tmp_path: Path) -> None:
    png = flat(tmp_path / "a.png", np.zeros((4, 4, 3), np.uint8))
    (tmp_path / "a.dpx").write_bytes(png.read_bytes())
    with pytest.raises(ReadError, match="not a DPX file: it is a PNG file"):
        read_image(tmp_path / "a.dpx")
    (tmp_path / "b.png").write_bytes(dpx(tmp_path / "b.dpx", codes(10), 10).read_bytes())
    with pytest.raises(ReadError, match="not a PNG file: it is a DPX file"):
        read_image(tmp_path / "b.png")


@pytest.mark.parametrize("bits", [8, 10, 12, 16])
def test_cut_short(tmp_path: Path, bits: int) -> None:
    path = dpx(tmp_path / "a.dpx", codes(bits, 3, 20, 30), bits)
    whole = path.read_bytes()
    for size in (len(whole) - 1, len(whole) - 200, 8200, 2100, 1000, 100, 4):
        path.write_bytes(whole[:size])
        for read in (read_image, read_data):
            with pytest.raises(ReadError, match=r"damaged|Could not read header|[Cc]orrupt|malicious") as caught:
                read(path)
            assert caught.value.file == str(path)
        assert not is_whole(path)


def test_a_header_of_a_huge_picture(tmp_path: Path) -> None:
    for side in (60_000, 20_000):
        path = dpx(tmp_path / "a.dpx", codes(10), 10, (WIDTH, struct.pack(">II", side, side)))
        with pytest.raises(ReadError, match=r"malicious|bytes are missing"):
            read_image(path)
    small = dpx(tmp_path / "b.dpx", codes(10), 10)
    with pytest.raises(ReadError, match="8x5 is more than 39 pixels"):
        read_image(small, settings=Settings(max_pixels=39))


def test_a_sequence_with_a_damaged_frame(tmp_path: Path) -> None:
    """The other frames are made; the exit code says that one is missing."""
    for frame in (1001, 1002, 1003):
        dpx(tmp_path / f"scan.{frame}.dpx", codes(10) // (frame - 1000), 10, transfer(LOGARITHMIC))
    bad = tmp_path / "scan.1002.dpx"
    bad.write_bytes(bad.read_bytes()[:-8])
    shot, out = str(tmp_path / "scan.####.dpx"), str(tmp_path / "out.####.exr")
    report = fa.run(document(), input=shot, output=out)
    assert report.exit_code == 1
    assert [frame.status for frame in report.frames] == ["done", "failed", "done"]
    assert report.frames[1].error is not None
    assert report.frames[1].error.code == "damaged"
    assert "scan.1002.dpx" in str(report.frames[1].error)
    made = read_image(tmp_path / "out.1003.exr")
    assert made.data_window == Window(0, 0, 8, 5)
    expected = 2 * cineon.linear((codes(10) // 3 / 1023).astype(np.float32))
    np.testing.assert_allclose(made.pixels, expected, rtol=2e-3, atol=1e-4)
    dpx(bad, codes(10), 10)
    again = fa.run(document(), input=shot, output=out)
    assert again.exit_code == 0
    assert [frame.status for frame in again.frames] == ["skipped", "done", "skipped"]
