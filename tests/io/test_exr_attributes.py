"""A header that is read byte by byte is written with the same bytes; what cannot be written is named."""

from __future__ import annotations

import struct
from fractions import Fraction
from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from flowabs_nodes.errors import ReadError
from flowabs_nodes.io.exr_attributes import stored_header
from tests.io.files import box, colors, exr, parts, planes


def test_values_that_others_look_at_are_plain(tmp_path: Path) -> None:
    chromaticities = (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329)
    plate = exr(tmp_path / "plate.exr", planes(colors()), chromaticities=chromaticities, multiView=["right", "left"])
    header, left_out = stored_header(str(plate), 0)
    assert header["chromaticities"] == pytest.approx(chromaticities)
    assert header["multiView"] == ["right", "left"]
    np.testing.assert_array_equal(header["dataWindow"], box(0, 0, 32, 24))
    assert not left_out


def test_each_part_has_its_own(tmp_path: Path) -> None:
    each = [(name, planes(colors()), {"note": name * 3}) for name in ("a", "b", "c")]
    plate = parts(tmp_path / "parts.exr", *each)
    assert [stored_header(str(plate), part)[0]["note"] for part in range(3)] == ["aaa", "bbb", "ccc"]
    with pytest.raises(ReadError, match="no windows"):
        stored_header(str(plate), 3)


@pytest.mark.parametrize(
    ("name", "value", "stored", "other"),
    [
        ("envmap", OpenEXR.ENVMAP_CUBE, b"envmap\0\1\0\0\0\1", b"envmap\0\1\0\0\0\2"),
        ("order", OpenEXR.DECREASING_Y, b"lineOrder\0\1\0\0\0\1", b"lineOrder\0\1\0\0\0\3"),
        ("method", OpenEXR.RLE_COMPRESSION, b"method\0compression\0\1\0\0\0\1", b"method\0compression\0\1\0\0\0\x63"),
        ("chromaticities", (0.1,) * 8, b"chromaticities\0chromaticities\0", b"chromaticities\0chromaXicities\0"),
        ("adoptedNeutral", np.zeros(2, np.float32), b"adoptedNeutral\0v2f", b"adoptedNeutral\0v2i"),
        ("rate", Fraction(24), b"rational\0\x08\0\0\0\x18\0\0\0\1\0\0\0", b"rational\0\4\0\0\0\x18\0\0\0"),
        ("texts", ["a", "b"], b"stringvector\0\x0a\0\0\0\1", b"stringvector\0\x0a\0\0\0\x7f"),
        ("take", 7, b"take\0int", b"t\xffke\0int"),
    ],
)
def test_what_no_exr_may_say_is_left_out_and_named(
    tmp_path: Path, name: str, value: object, stored: bytes, other: bytes
) -> None:
    plate = exr(tmp_path / "plate.exr", planes(colors()), **{name: value})
    data = plate.read_bytes()
    assert data.count(stored) == 1
    plate.write_bytes(data.replace(stored, other))
    header, left_out = stored_header(str(plate), 0)
    assert name not in header
    assert left_out == [name if name != "take" else "t\N{REPLACEMENT CHARACTER}ke"]


def test_an_attribute_that_is_longer_than_the_file(tmp_path: Path) -> None:
    plate = exr(tmp_path / "plate.exr", planes(colors()), note="abc")
    data = plate.read_bytes()
    plate.write_bytes(data.replace(struct.pack("<I", 3) + b"abc", struct.pack("<I", 2**31) + b"abc"))
    with pytest.raises(ReadError, match="longer than the file"):
        stored_header(str(plate), 0)
