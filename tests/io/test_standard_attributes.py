"""Standard attributes have their EXR type, whatever the graph gives; what cannot be of the type is refused."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import pytest

from flowabs_nodes.image import Image
from flowabs_nodes.io.standard_attributes import standard_value
from flowabs_nodes.nodes.write import WRITE
from tests.io.files import colors, written


@pytest.mark.parametrize(
    ("given", "rate"),
    [
        (24, (24, 1)),
        (25.0, (25, 1)),
        (12.5, (25, 2)),
        (23.976, (24000, 1001)),
        (23.98, (24000, 1001)),
        (29.97, (30000, 1001)),
        (59.94, (60000, 1001)),
        ("24000/1001", (24000, 1001)),
        ("48", (48, 1)),
    ],
)
def test_rates(given: Any, rate: tuple[int, int]) -> None:
    assert standard_value("framesPerSecond", given) == Fraction(*rate)


def test_they_are_written_in_their_types(tmp_path: Path) -> None:
    metadata = {
        "framesPerSecond": 24,
        "timeCode": "01:02:03:04",
        "expTime": 1,
        "ExposureTime": "1/48",
        "isoSpeed": 800,
        "reelName": 12,
        "imageCounter": 7.0,
        "adoptedNeutral": "0.3127, 0.329",
        "keyCode": "1 2 3 4 5 4 64",
        "take": 3,
        "gain": 1.5,
    }
    out, _ = written(Image.from_array(colors()), tmp_path / "out.exr", metadata=metadata)
    header = OpenEXR.File(str(out), header_only=True).header()
    assert header["framesPerSecond"] == Fraction(24)
    timecode = header["timeCode"]
    assert (timecode.hours, timecode.minutes, timecode.seconds, timecode.frame) == (1, 2, 3, 4)
    assert not timecode.dropFrame
    assert (type(header["isoSpeed"]), header["isoSpeed"]) == (float, 800)
    assert header["expTime"] == pytest.approx(1 / 48)  # the last that is given
    assert (header["reelName"], header["imageCounter"], header["take"], header["gain"]) == ("12", 7, 3, 1.5)
    np.testing.assert_allclose(header["adoptedNeutral"], [0.3127, 0.329])
    assert isinstance(header["keyCode"], OpenEXR.KeyCode)


def test_drop_frame() -> None:
    assert standard_value("timeCode", "00:59:59;29").dropFrame


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("framesPerSecond", "fast", "frames a second"),
        ("framesPerSecond", 0, "frames a second"),
        ("captureRate", "1/0", "frames a second"),
        ("timeCode", "01:00:00", "time code"),
        ("timeCode", 86400, "time code"),
        ("smpte:TimeCode", "25:00:00:00", "at most 23"),
        ("expTime", "long", "a number"),
        ("imageCounter", 1.5, "a whole number"),
        ("worldToCamera", "1 2 3", "16 numbers"),
        ("keyCode", "1 2", "seven"),
    ],
)
def test_other_values_are_refused_before_a_frame_is_made(name: str, value: Any, expected: str) -> None:
    metadata = next(each for each in WRITE.params if each.name == "metadata")
    problem = metadata.parse({name: value})
    assert expected in problem
    assert repr(name) in problem
