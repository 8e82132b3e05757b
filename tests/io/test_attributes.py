"""Metadata in OpenImageIO's words becomes EXR attributes as OpenImageIO itself would write them, and comes back."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import OpenImageIO as oiio
import pytest

from flowabs_nodes.io.attributes import describes_picture, settable, to_exr, to_spec, values
from tests.io.files import attributes, exr

MADE: dict[str, tuple[Any, Any]] = {
    "Copyright": (oiio.TypeString, "studio"),
    "DateTime": (oiio.TypeString, "2004:01:04 18:10:00"),
    "ImageDescription": (oiio.TypeString, "view from the hill"),
    "ExposureTime": (oiio.TypeFloat, 0.5),
    "FNumber": (oiio.TypeFloat, 2.5),
    "shot": (oiio.TypeString, "hé"),
    "take": (oiio.TypeInt, -7),
    "smpte:TimeCode": (oiio.TypeTimeCode, (0x41122384, 0x12345678)),
    "smpte:KeyCode": (oiio.TypeKeyCode, (1, 2, 3, 4, 5, 4, 64)),
    "framesPerSecond": (oiio.TypeRational, (24000, 1001)),
    "chromaticities": (oiio.TypeDesc("float[8]"), (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329)),
    "worldToCamera": (oiio.TypeMatrix, tuple(float(i) for i in range(16))),
    "m33": (oiio.TypeMatrix33, tuple(float(i) for i in range(9))),
    "v2": (oiio.TypeFloat2, (1.0, 2.0)),
    "v3": (oiio.TypeVector, (1.0, 2.0, 3.0)),
    "v2i": (oiio.TypeVector2i, (1, 2)),
    "v3i": (oiio.TypeVector3i, (1, 2, 3)),
    "five": (oiio.TypeDesc("float[5]"), (1.0, 2.0, 3.0, 4.0, 5.0)),
    "multiView": (oiio.TypeDesc("string[2]"), ("right", "left")),
    "box": (oiio.TypeBox2, (1.0, 2.0, 3.0, 4.0)),
    "boxi": (oiio.TypeBox2i, (1, 2, 3, 4)),
}


def test_as_openimageio_writes_them(tmp_path: Path) -> None:
    spec = oiio.ImageSpec(4, 4, 1, oiio.HALF)
    spec.channelnames = ("Y",)
    for name, (kind, value) in MADE.items():
        spec.attribute(name, kind, value)
    theirs = tmp_path / "oiio.exr"
    output = oiio.ImageOutput.create(str(theirs))
    assert output.open(str(theirs), spec)
    assert output.write_image(np.zeros((4, 4, 1), np.float32))
    output.close()

    header = dict(filter(None, (to_exr(name, kind, value) for name, (kind, value) in values(spec).items())))
    ours = exr(tmp_path / "ours.exr", {"Y": np.zeros((4, 4), np.float16)}, **header)
    expected, found = attributes(theirs), attributes(ours)
    for name in MADE:
        assert found[name] == expected[name], name


def test_what_exr_cannot_say() -> None:
    assert to_exr("x" * 300, "string", "text") is None
    assert to_exr("big", "int64", 2**40) == ("big", str(2**40))
    assert to_exr("bad", "string", "\udcff") == ("bad", "?")
    assert to_exr("b\udcffd", "string", "text") is None
    name, pair = to_exr("rate", "rational", (24, 0))  # no fraction: kept as two numbers
    assert (name, list(pair)) == ("rate", [24, 0])
    assert to_exr("none", "string[0]", ()) is None


def test_from_an_exr_header() -> None:
    spec = oiio.ImageSpec(4, 4, 1, oiio.HALF)
    chromaticities = (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329)
    header = {
        "owner": "me",
        "take": 3,
        "gain": 1.5,
        "chromaticities": chromaticities,
        "compression": OpenEXR.ZIP_COMPRESSION,
    }
    to_spec(header | {"centre": np.array([1, 2], np.float32)}, spec)
    assert spec.get_string_attribute("Copyright") == "me"
    assert spec.getattribute("take") == 3
    assert spec.getattribute("chromaticities") == pytest.approx(chromaticities)
    assert spec.getattribute("centre") == (1.0, 2.0)
    assert spec.getattribute("compression") is None


def test_what_may_be_set() -> None:
    assert all(settable(name) for name in ("shot", "Copyright", "DateTime", "my/attr", "smpte:TimeCode"))
    refused = (
        "",
        "channels",
        "dataWindow",
        "type",
        "compression",
        "flowabs:key",
        "oiio:ColorSpace",
        "PixelAspectRatio",
    )
    assert not any(settable(name) for name in (*refused, "a\0b", "x" * 256))


def test_what_describes_the_picture() -> None:
    assert describes_picture("cryptomatte/abc/manifest")
    assert not any(
        describes_picture(name) for name in ("tiff:Compression", "ICCProfile:size", "oiio:subimages", "thumbnail_width")
    )
