"""What an EXR keeps on its way through a graph: kinds of plates, each against every promise of docs/exr.md.

Each kind goes through a graph that reads and writes, and one that flattens lightness in between. No promise may be
broken; those that a kind is there for must have found something to look at.
"""

from __future__ import annotations

import dataclasses
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.io.files import deep, exr, luminance_chroma
from tests.io.plates import AP0, BITS, KINDS, TIME, plain, several_parts
from tools.reliability.exr_facts import Attribute, Part, read_headers
from tools.reliability.fidelity import Refused, main, passage, rows
from tools.reliability.promises import PROMISES, Passage


@pytest.mark.parametrize(("name", "way"), [(name, way) for name, kind in KINDS.items() for way in kind.ways])
def test_what_is_kept(tmp_path: Path, name: str, way: str) -> None:
    kind = KINDS[name]
    kind.write(tmp_path / "plate.exr")
    ends = passage(tmp_path / "plate.exr", way, tmp_path / "made.exr")
    found = {promise: kept(ends) for promise, kept in PROMISES.items()}
    assert not {promise: said for promise, said in found.items() if said}
    unseen = {promise for promise in kind.proves.split(", ") if found[promise] is None}
    assert unseen <= ({"colours"} if way == "quantize" else set())
    assert [warning for warning in ends.warnings if kind.warns not in warning] == []
    assert bool(ends.warnings) == bool(kind.warns)


def test_deep_data_and_other_subsampled_channels_are_refused(tmp_path: Path) -> None:
    """No picture is made of either; where the picture is beside a deep part, the deep part alone is not there."""
    with pytest.raises(Refused, match="deep data"):
        passage(deep(tmp_path / "deep.exr"), "copy", tmp_path / "made.exr")
    whole, half = np.ones((8, 8), np.float32), np.ones((4, 4), np.float32)
    luminance_chroma(tmp_path / "rgb.exr", {"R": (whole, 1), "G": (half, 2), "B": (half, 2)})
    with pytest.raises(Refused, match="ubsampl"):
        passage(tmp_path / "rgb.exr", "copy", tmp_path / "made.exr")
    assert not (tmp_path / "made.exr").exists()


# ---------------------------------------------------------------------- the promises themselves


def without(name: str) -> Callable[[Part], Part]:
    return lambda part: dataclasses.replace(part, header={n: a for n, a in part.header.items() if n != name})


def with_attribute(name: str, kind: str, value: bytes) -> Callable[[Part], Part]:
    return lambda part: dataclasses.replace(part, header={**part.header, name: Attribute(kind, value)})


def with_pixels(name: str, change: Callable[[np.ndarray], np.ndarray]) -> Callable[[Part], Part]:
    return lambda part: dataclasses.replace(part, channels={**part.channels, name: change(part.channels[name])})


def flipped(plane: np.ndarray) -> np.ndarray:
    """Return a plane with one bit changed."""
    data = bytearray(plane.tobytes())
    data[40] ^= 1
    return np.frombuffer(bytes(data), plane.dtype).reshape(plane.shape)


BROKEN: list[tuple[str, Callable[[Part], Part]]] = [
    ("display window", with_attribute("displayWindow", "box2i", struct.pack("<4i", 0, 0, 31, 24))),
    ("data window", with_attribute("dataWindow", "box2i", struct.pack("<4i", 0, 1, 31, 24))),
    ("pixel aspect", with_attribute("pixelAspectRatio", "float", struct.pack("<f", 1))),
    ("chromaticities", without("chromaticities")),
    ("time code", with_attribute("timeCode", "timecode", bytes(8))),
    ("attributes", without("note")),
    ("attributes", with_attribute("note", "mystery", b"mine")),
    ("attributes", with_attribute("new", "int", bytes(4))),
    ("alpha", with_pixels("A", flipped)),
    ("colours", with_pixels("G", flipped)),
    ("colours", with_pixels("R", lambda plane: plane.astype(np.float32))),
    ("layers", with_pixels("id", flipped)),
    ("layers", lambda part: dataclasses.replace(part, channels={n: c for n, c in part.channels.items() if n != "id"})),
    ("compression", with_attribute("compression", "compression", b"\x08")),
]


@pytest.fixture(scope="module")
def kept_passage(tmp_path_factory: pytest.TempPathFactory) -> Passage:
    folder = tmp_path_factory.mktemp("kept")
    header = {"chromaticities": AP0, "timeCode": TIME, "note": "mine", "pixelAspectRatio": 2.0}
    exr(folder / "plate.exr", plain(4) | {"id": BITS}, **header)
    return passage(folder / "plate.exr", "copy", folder / "made.exr")


@pytest.mark.parametrize(("promise", "change"), BROKEN)
def test_what_breaks_a_promise_is_seen(kept_passage: Passage, promise: str, change: Callable[[Part], Part]) -> None:
    assert not any(kept(kept_passage) for kept in PROMISES.values())
    broken = dataclasses.replace(kept_passage, after=(change(kept_passage.made),))
    assert [name for name, kept in PROMISES.items() if kept(broken)] == [promise]


def test_a_colour_space_that_is_not_said_or_not_found_again_is_seen(kept_passage: Passage) -> None:
    for change in ({"notes": ()}, {"spaces": ("lin_ap0_scene", "lin_rec709")}):
        assert PROMISES["colour space"](dataclasses.replace(kept_passage, **change))


def test_the_tool_makes_a_table_and_says_what_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    exr(tmp_path / "plate.exr", plain())
    exr(tmp_path / "depth.exr", {"Z": BITS.view(np.float32)})
    whole = exr(tmp_path / "cut.exr", plain()).read_bytes()
    (tmp_path / "cut.exr").write_bytes(whole[:-500])
    monkeypatch.setattr("sys.argv", ["fidelity", str(tmp_path)])
    assert main() == 0
    printed = capsys.readouterr().out
    assert "3 files, 1 refused; 0 promises broken" in printed
    assert [row.way for row in rows(tmp_path / "depth.exr")] == ["data"]
    monkeypatch.setitem(PROMISES, "alpha", lambda passage: "gone")
    assert main() == 1
    assert "plate.exr, copy: alpha: gone" in capsys.readouterr().out


def test_headers_are_read_byte_by_byte(tmp_path: Path) -> None:
    several_parts(tmp_path / "parts.exr")
    headers = read_headers(tmp_path / "parts.exr")
    assert [header["name"].value for header in headers] == [b"depth_left", b"rgba_right", b"rgba_left", b"ids"]
    assert headers[1]["note"] == Attribute("string", b"mine")
