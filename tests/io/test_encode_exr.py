"""What goes into an EXR: pixels, data types, compression, colour tags, and everything the plate's header says."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import OpenImageIO as oiio
import pytest

from flowabs_nodes.color import space, spaces
from flowabs_nodes.errors import ReadError, WriteError
from flowabs_nodes.image import Image, Window
from flowabs_nodes.io.read import read_data, read_image
from flowabs_nodes.io.write import build_picture, save, stored_key
from tests.io.files import attributes, box, colors, exr, flat, native, parts, planes, same_bits, windowed

AP0 = (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767)


def written(
    image: Image, path: Path, *, layers: dict[str, Image] | None = None, **options: Any
) -> tuple[Path, list[str]]:
    warned: list[str] = []
    save(build_picture(image, layers, warn=warned.append, **options), path, key="k", graph="{}", warn=warned.append)
    return path, warned


def like(image: Image, pixels: np.ndarray, type: Any = None) -> Image:
    return image.with_pixels(np.asarray(pixels, np.float32), type)


def rich_header() -> dict[str, Any]:
    timecode = OpenEXR.TimeCode(1, 2, 3, 4, 1, 0, 0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8)
    return {
        "pixelAspectRatio": 2.0,
        "chromaticities": AP0,
        "timeCode": timecode,
        "framesPerSecond": Fraction(24000, 1001),
        "keyCode": OpenEXR.KeyCode(1, 2, 3, 4, 5, 4, 64),
        "screenWindowWidth": 1.5,
        "owner": "Studio Ltd",
        "comments": "first pass",
        "capDate": "2004:01:04 18:10:00",
        "shot/take": 7,
        "gain": 1.25,
        "note": "hé",
        "m44": np.arange(16, dtype=np.float32).reshape(4, 4),
        "m33d": np.arange(9, dtype=np.float64).reshape(3, 3),
        "v2d": np.array([1, 2], np.float64),
        "v3i": np.array([1, 2, 3], np.int32),
        "strings": ["a", "bb"],
        "floats": [1.0, 2.0, 3.0, 4.0, 5.0],
        "multiView": ["right", "left"],
        "bounds": box(1, 2, 3, 4),
        "cryptomatte/abc1234/manifest": '{"bunny":"deadbeef"}',
        "odd": OpenEXR.OpaqueAttribute(b"\0\1\2\3", "mystery"),
        "wrapmodes": "clamp",
    }


def test_everything_in_the_header_stays(tmp_path: Path) -> None:
    plate = windowed(tmp_path / "plate.exr", **rich_header())
    image = read_image(plate)
    out, warned = written(like(image, image.pixels * 2), tmp_path / "out.exr")
    assert attributes(out) == attributes(plate)
    before, after = (OpenEXR.File(str(path), header_only=True).header() for path in (plate, out))
    for name in set(before) - {"channels", "type"}:
        assert str(after[name]) == str(before[name]), name
    assert set(after) - set(before) == {"flowabs:key", "flowabs:graph"}
    assert b"odd\0mystery\0\4\0\0\0\0\1\2\3" in out.read_bytes()
    assert not warned


def test_pixels_come_back_bit_for_bit(tmp_path: Path) -> None:
    plate = windowed(tmp_path / "plate.exr")
    out, _ = written(read_image(plate), tmp_path / "out.exr")
    before, after = native(plate), native(out)
    assert set(before) == set(after)
    assert all(same_bits(before[name], after[name]) for name in before)
    image = read_image(out)
    assert image.data_window == Window(3, -2, 32, 24)
    assert image.display_window == Window(-5, 0, 40, 30)


def test_tiled_multipart_and_mipmapped_plates_become_scanlines(tmp_path: Path) -> None:
    tiles = OpenEXR.TileDescription()
    tiles.xSize = tiles.ySize = 16
    plate = exr(tmp_path / "t.exr", planes(colors()), type=OpenEXR.tiledimage, tiles=tiles, owner="me")
    out, _ = written(read_image(plate), tmp_path / "out.exr")
    assert attributes(out) == attributes(plate)
    assert oiio.ImageInput.open(str(out)).spec().tile_width == 0


def test_nodes_may_change_metadata(tmp_path: Path) -> None:
    plate = windowed(tmp_path / "plate.exr", **rich_header())
    image = read_image(plate)
    spec = image.spec
    spec.attribute("gain", 3.0)
    spec.attribute("new", "yes")
    spec.attribute("Copyright", "someone else")
    spec.erase_attribute("note")
    out, _ = written(
        Image(image.pixels, spec, "color", colorspace=image.colorspace, origin=image.origin), tmp_path / "out.exr"
    )
    found = attributes(out)
    assert found["gain"] == ("float", 3.0)
    assert found["new"] == ("string", "yes")
    assert found["Copyright"] == ("string", "someone else")
    assert "note" not in found
    assert found["m44"] == attributes(plate)["m44"]


def test_an_image_without_a_file_keeps_its_metadata(tmp_path: Path) -> None:
    plate = windowed(tmp_path / "plate.exr", **rich_header())
    buf = oiio.ImageBuf(str(plate))
    out, _ = written(Image.from_imagebuf(buf), tmp_path / "out.exr")
    before, after = attributes(plate), attributes(out)
    translated = (
        "smpte:TimeCode",
        "framesPerSecond",
        "m44",
        "strings",
        "floats",
        "Copyright",
        "shot/take",
        "chromaticities",
    )
    for name in (*translated, "PixelAspectRatio", "cryptomatte/abc1234/manifest", "multiView", "smpte:KeyCode"):
        assert after[name] == before[name], name


def test_a_header_that_is_no_utf8(tmp_path: Path) -> None:
    plate = windowed(tmp_path / "plate.exr", note="abcdef", gain=2.0)
    plate.write_bytes(plate.read_bytes().replace(b"abcdef", b"abc\xff\xfef"))
    out, warned = written(read_image(plate), tmp_path / "out.exr")
    assert "word for word" in warned[0]
    assert attributes(out)["gain"] == ("float", 2.0)


def test_the_stamps_of_another_run_do_not_stay(tmp_path: Path) -> None:
    first, _ = written(read_image(windowed(tmp_path / "plate.exr")), tmp_path / "first.exr")
    image = read_image(first)
    save(build_picture(image), tmp_path / "second.exr", key="other")
    assert stored_key(first) == "k"
    assert stored_key(tmp_path / "second.exr") == "other"
    header = OpenEXR.File(str(tmp_path / "second.exr"), header_only=True).header()
    assert "flowabs:graph" not in header


def test_metadata_parameter(tmp_path: Path) -> None:
    image = read_image(windowed(tmp_path / "plate.exr"))
    out, _ = written(
        image, tmp_path / "out.exr", metadata={"Copyright": "us", "take": 3, "gain": 0.5, "a" * 60: "long"}
    )
    found = attributes(out)
    assert found["Copyright"] == ("string", "us")
    assert found["take"] == ("int", 3)
    assert found["gain"] == ("float", 0.5)
    assert found["a" * 60] == ("string", "long")


# ---------------------------------------------------------------------- channels and data types


def test_layers(tmp_path: Path) -> None:
    image = read_image(windowed(tmp_path / "plate.exr"))
    one = np.linspace(0, 1, 24 * 32, dtype=np.float32).reshape(24, 32, 1)
    data = exr(tmp_path / "d.exr", {"forward.u": one[..., 0], "forward.v": one[..., 0]}, dataWindow=box(3, -2, 32, 24))
    out, warned = written(
        like(image, one, "matte"),
        tmp_path / "out.exr",
        layers={
            "ink": like(image, colors(channels=4), "color"),
            "lines": like(image, one, "matte"),
            "lic": like(image, one, "mono"),
            "etf": like(image, np.repeat(one, 2, 2), "flow"),
            "motion": read_data(data),
        },
    )
    found = native(out)
    assert {name: str(plane.dtype) for name, plane in found.items()} == {
        **dict.fromkeys(("R", "G", "B", "ink.R", "ink.G", "ink.B", "ink.A", "lines.Y", "lic.Y"), "float16"),
        **dict.fromkeys(("etf.x", "etf.y", "motion.u", "motion.v"), "float32"),
    }
    for name in ("R", "G", "B", "lines.Y", "lic.Y"):
        np.testing.assert_array_equal(found[name], one[..., 0].astype(np.float16))
    assert same_bits(found["motion.u"], one[..., 0])
    assert not warned


def test_a_flow_as_the_main_image(tmp_path: Path) -> None:
    image = read_image(windowed(tmp_path / "plate.exr"))
    out, _ = written(like(image, colors(channels=3)[..., :2], "flow"), tmp_path / "out.exr")
    found = native(out)
    assert set(found) == {"flow.x", "flow.y"}
    assert found["flow.x"].dtype == np.float32


def test_two_of_one_name_are_refused(tmp_path: Path) -> None:
    flow = like(read_image(windowed(tmp_path / "plate.exr")), colors()[..., :2], "flow")
    with pytest.raises(WriteError, match=r"flow\.x would be both"):
        written(flow, tmp_path / "out.exr", layers={"flow": flow})


def test_data_channels_of_one_last_name_keep_all_of_theirs(tmp_path: Path) -> None:
    plane = np.zeros((24, 32), np.float32)
    path = exr(tmp_path / "d.exr", {"f.left.u": plane, "f.right.u": plane + 1})
    image = read_image(exr(tmp_path / "p.exr", planes(colors())))
    out, _ = written(image, tmp_path / "out.exr", layers={"n": read_data(path, layer="f")})
    assert {"n.f.left.u", "n.f.right.u"} < set(native(out))


def test_layers_on_another_window_are_cut_to_the_image(tmp_path: Path) -> None:
    image = read_image(windowed(tmp_path / "plate.exr"))
    other = Image.from_array(np.ones((24, 32), np.float32), type="matte")
    out, warned = written(image, tmp_path / "out.exr", layers={"n": other})
    assert "data window" in warned[0]
    np.testing.assert_array_equal(native(out)["n.Y"][2:, :29], 1)
    np.testing.assert_array_equal(native(out)["n.Y"][:2], 0)


@pytest.mark.parametrize(
    ("plate", "data_type", "expected"),
    [
        (np.float16, "auto", np.float16),
        (np.float32, "auto", np.float32),
        (np.float16, "float", np.float32),
        (np.float32, "half", np.float16),
    ],
)
def test_data_type(tmp_path: Path, plate: Any, data_type: str, expected: Any) -> None:
    image = read_image(exr(tmp_path / "plate.exr", planes(colors(dtype=plate))))
    out, warned = written(image, tmp_path / "out.exr", data_type=data_type, layers={"l": like(image, image.pixels)})
    assert {plane.dtype for plane in native(out).values()} == {np.dtype(expected)}
    assert not warned


def test_photographs_become_half_and_say_what_they_are(tmp_path: Path) -> None:
    image = read_image(flat(tmp_path / "a.png", (colors() * 100).astype(np.uint8), Copyright="me", XResolution=72.0))
    out, warned = written(image, tmp_path / "out.exr", data_type="uint8")
    assert native(out)["R"].dtype == np.float16
    assert "EXR cannot hold uint8" in warned[0]
    header = OpenEXR.File(str(out), header_only=True).header()
    assert header["colorInteropID"] == "lin_rec709_scene"
    assert header["owner"] == "me"
    assert OpenEXR.checkColorMetadata(header) == 0
    assert "xDensity" not in header


def test_overflow_is_clamped_and_counted(tmp_path: Path) -> None:
    pixels = np.array([[[65504, 65505, -1e9], [np.nan, np.inf, 1]]], np.float32)
    out, warned = written(Image.from_array(pixels), tmp_path / "out.exr")
    found = native(out)
    np.testing.assert_array_equal(found["R"], np.array([[65504, 0]], np.float16))
    np.testing.assert_array_equal(found["G"], np.array([[65504, 65504]], np.float16))
    np.testing.assert_array_equal(found["B"], np.array([[-65504, 1]], np.float16))
    assert warned == ["image: 1 NaN written as 0", "image: 3 values beyond half clamped to ±65504"]


def test_data_layers_keep_nan_and_inf_and_say_so(tmp_path: Path) -> None:
    depth = np.array([[np.inf, np.nan, 1e9]], np.float32)
    data = read_data(exr(tmp_path / "z.exr", {"Z": depth}))
    image = Image.from_array(np.ones((1, 3, 3), np.float32))
    out, warned = written(image, tmp_path / "a.exr", layers={"depth": data})
    assert same_bits(native(out)["depth.Z"], depth)
    assert warned == ["depth: 1 NaN and 1 Inf written as they are"]
    out, warned = written(image, tmp_path / "b.exr", layers={"depth": data}, data_type="half")
    np.testing.assert_array_equal(native(out)["depth.Z"], np.array([[np.inf, np.nan, 65504]], np.float16))
    assert "clamped" in warned[1]


# ---------------------------------------------------------------------- compression


@pytest.mark.parametrize(
    ("plate", "dtype", "expected"),
    [
        ("PIZ", np.float16, "piz"),
        ("ZIPS", np.float32, "zips"),
        ("NO", np.float16, "none"),
        ("PXR24", np.float16, "pxr24"),
        ("PXR24", np.float32, "zip"),  # it keeps 24 of the 32 bits
        ("DWAA", np.float16, "zip"),
        ("B44", np.float16, "zip"),
    ],
)
def test_auto_compression_is_the_plates_where_it_loses_nothing(
    tmp_path: Path, plate: str, dtype: Any, expected: str
) -> None:
    compression = getattr(OpenEXR, f"{plate}_COMPRESSION")
    image = read_image(exr(tmp_path / "plate.exr", planes(colors(dtype=dtype)), compression=compression))
    out, warned = written(image, tmp_path / "out.exr")
    assert oiio.ImageInput.open(str(out)).spec().get_string_attribute("compression") == expected
    assert not warned


def test_lossy_compression_is_for_those_who_ask(tmp_path: Path) -> None:
    image = read_image(windowed(tmp_path / "plate.exr"))
    for compression in ("dwaa", "dwab", "b44", "b44a"):
        out, warned = written(image, tmp_path / "out.exr", compression=compression)
        assert oiio.ImageInput.open(str(out)).spec().get_string_attribute("compression").startswith(compression)
        assert "changes the picture" in warned[0]
    _, warned = written(image, tmp_path / "out.exr", compression="piz")
    assert not warned


# ---------------------------------------------------------------------- alpha and colour


def test_an_alpha_of_zero_everywhere_is_written_as_it_was(tmp_path: Path) -> None:
    pixels = colors(channels=4)
    pixels[..., 3] = 0
    plate = exr(tmp_path / "carrots.exr", planes(pixels))
    image = read_image(plate)
    out, _ = written(like(image, image.pixels + 1), tmp_path / "out.exr", layers={"n": image})
    found = native(out)
    assert same_bits(found["A"], native(plate)["A"])
    assert "n.A" not in found
    assert "A" not in native(written(like(image, image.pixels[..., :1], "matte"), tmp_path / "m.exr")[0])


def test_an_ignored_alpha_is_written_as_it_was(tmp_path: Path) -> None:
    plate = windowed(tmp_path / "plate.exr")
    channels: dict[str, np.ndarray] = native(plate) | {"A": colors()[..., 0].astype(np.float32)}
    header = {
        name: value for name, value in OpenEXR.File(str(plate), header_only=True).header().items() if "Window" in name
    }
    plate = exr(tmp_path / "alpha.exr", channels, **header)
    image = read_image(plate, alpha="ignore")
    out, _ = written(image, tmp_path / "out.exr")
    assert same_bits(native(out)["A"], channels["A"])
    moved = image.on_window(Window(0, 0, 10, 10))
    out, _ = written(moved, tmp_path / "moved.exr")
    placed = np.zeros((10, 10), np.float32)
    placed[:, 3:] = channels["A"][2:12, :7]  # the corner of the plate's window is (3, -2), of the new one (0, 0)
    np.testing.assert_array_equal(native(out)["A"], placed)


def test_a_plate_that_is_gone_takes_nothing_with_it_silently(tmp_path: Path) -> None:
    pixels = colors(channels=4)
    plate = exr(tmp_path / "plate.exr", planes(pixels))
    ignored, image = read_image(plate, alpha="ignore"), read_image(plate)
    plate.unlink()
    for lost, options in ((ignored, {}), (image, {"keep_layers": "*"})):
        with pytest.raises(ReadError, match="no such file"):
            written(lost, tmp_path / "out.exr", **options)
    assert not (tmp_path / "out.exr").exists()
    _, warned = written(image, tmp_path / "out.exr")
    assert "word for word" in warned[0]


def test_the_plates_colour_tags_stay(tmp_path: Path) -> None:
    for header in ({}, {"chromaticities": AP0}, {"colorInteropID": "lin_ap1_scene"}):
        plate = windowed(tmp_path / "plate.exr", **header)
        out, _ = written(read_image(plate), tmp_path / "out.exr")
        assert attributes(out) == attributes(plate)


def test_another_colour_space_is_converted_and_tagged(tmp_path: Path) -> None:
    pixels = colors(channels=4).astype(np.float32)
    plate = exr(tmp_path / "plate.exr", planes(pixels), chromaticities=AP0)
    image = read_image(plate)
    matte = like(image, pixels[..., :1], "matte")
    out, _ = written(image, tmp_path / "out.exr", colorspace="ACEScg", layers={"lines": matte})
    header = OpenEXR.File(str(out), header_only=True).header()
    assert header["colorInteropID"] == "lin_ap1_scene"  # the standard name, whichever alias was asked for
    np.testing.assert_allclose(header["chromaticities"], (0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767))
    back = read_image(out)
    assert back.colorspace.name == "lin_ap1_scene"
    assert np.abs(back.pixels - image.pixels)[..., :3].max() > 0.01
    np.testing.assert_array_equal(native(out)["lines.Y"], pixels[..., 0])  # no colour, no conversion
    again, _ = written(back, tmp_path / "again.exr", colorspace="ACES2065-1")
    np.testing.assert_allclose(read_image(again).pixels, image.pixels, atol=1e-5)


def test_an_encoding_keeps_its_own_name(tmp_path: Path) -> None:
    out, _ = written(Image.from_array(colors()), tmp_path / "log.exr", colorspace="ACEScct")
    assert OpenEXR.File(str(out), header_only=True).header()["colorInteropID"] == "ACEScct"
    back = read_image(out)  # in the primaries of that encoding
    assert back.colorspace.name == "lin_ap1_scene"
    rgb = spaces.convert(back.pixels, back.colorspace, space("lin_rec709"))
    np.testing.assert_allclose(rgb, colors(), rtol=2e-2, atol=2e-2)  # half floats of a log encoding


def test_a_part_of_a_file_becomes_a_file(tmp_path: Path) -> None:
    plate = parts(
        tmp_path / "parts.exr",
        ("depth", {"Z": np.ones((24, 32), np.float32)}, {}),
        ("beauty", planes(colors()), {"note": "mine", "view": "left"}),
    )
    out, _ = written(read_image(plate), tmp_path / "out.exr")
    assert attributes(out) == attributes(plate, 1)
