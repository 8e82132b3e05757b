"""What an EXR's header says where a node or a parameter changed it, and which colours these are.

What stays as it was: test_fidelity.py.
"""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import OpenImageIO as oiio
import pytest

from flowabs_nodes.color import space, spaces
from flowabs_nodes.image import Image
from flowabs_nodes.io.read import read_image
from tests.io.files import (
    attributes,
    box,
    colors,
    exr,
    like,
    native,
    parts,
    planes,
    windowed,
    written,
)

AP0 = (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767)


def rich_header() -> dict[str, Any]:
    """Return attributes of many types."""
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


def aces(tmp_path: Path, **changed: Any) -> Path:
    header = {"acesImageContainerFlag": 1, "chromaticities": AP0, "compression": OpenEXR.NO_COMPRESSION}
    return exr(tmp_path / "aces.exr", planes(colors()), **(header | changed))


def flag(path: Path) -> Any:
    return OpenEXR.File(str(path), header_only=True).header().get("acesImageContainerFlag")


@pytest.mark.parametrize(
    ("read", "write"),
    [
        ({}, {"compression": "zip"}),
        ({}, {"data_type": "float"}),
        ({}, {"colorspace": "lin_rec709"}),
        ({}, {"colorspace": "ACEScg"}),
        ({"colorspace": "lin_rec709"}, {}),
        ({}, {"layers": {"lines": None}}),
    ],
)
def test_what_is_no_aces_container_does_not_say_so(tmp_path: Path, read: Any, write: Any) -> None:
    image = read_image(aces(tmp_path), **read)
    if "layers" in write:
        write = {"layers": {"lines": like(image, image.pixels[..., :1], "matte")}}
    assert flag(written(image, tmp_path / "out.exr", **write)[0]) is None
