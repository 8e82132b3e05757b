"""Channels of hosts' pictures, by name and in any order."""

from __future__ import annotations

from typing import Any

import pytest

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.image.channels import layout, picks
from flowabs_nodes.port_types import TYPES

RGBA = ("R", "G", "B", "A")


@pytest.mark.parametrize(
    ("count", "type", "channels", "expected"),
    [
        (4, None, None, ("color", RGBA, (0, 1, 2, 3))),
        (4, None, "BGRA", ("color", RGBA, (2, 1, 0, 3))),
        (4, None, ("A", "R", "G", "B"), ("color", RGBA, (1, 2, 3, 0))),
        (4, None, "BGRX", ("color", RGBA[:3], (2, 1, 0))),
        (3, None, "BGR", ("color", RGBA[:3], (2, 1, 0))),
        (4, "normal", ("N.Z", "N.Y", "N.X", "N.W"), ("normal", ("N.Z", "N.Y", "N.X", "N.W"), (0, 1, 2, 3))),
        (3, "normal", ("N.Z", "N.Y", "N.X"), ("normal", ("N.X", "N.Y", "N.Z"), (2, 1, 0))),
        (2, None, ("u", "v"), ("data", ("u", "v"), (0, 1))),
        (2, None, ("X", "Y"), ("data", ("X", "Y"), (0, 1))),
        (1, None, "Y", ("mono", ("Y",), (0,))),
        (1, "matte", None, ("matte", ("Y",), (0,))),
    ],
)
def test_channels_are_found_by_name(count: int, type: Any, channels: Any, expected: Any) -> None:
    assert tuple(layout(count, type, channels)) == expected


@pytest.mark.parametrize(
    ("kind", "names", "channels", "expected"),
    [
        ("color", RGBA, None, (0, 1, 2, 3)),
        ("color", RGBA, "BGRA", (2, 1, 0, 3)),
        ("color", RGBA, "A", (3,)),
        ("color", RGBA[:3], "RGBA", (0, 1, 2, None)),
        ("color", RGBA, "BGRX", (2, 1, 0, None)),
        ("matte", ("Y",), "RGBA", (0, 0, 0, None)),
        ("mono", ("Y",), ("Y",), (0,)),
        ("depth", ("Z",), "Z", (0,)),
        ("data", ("X", "A", "N.X"), ("A", "X"), (1, 0)),
        ("data", ("X", "A", "N.X"), "N.X", (2,)),
    ],
)
def test_a_host_picks_channels_by_name(kind: str, names: Any, channels: Any, expected: Any) -> None:
    assert picks(TYPES[kind], names, channels) == expected


@pytest.mark.parametrize(
    ("channels", "message"),
    [("RGBY", "a color image of R,G,B,A has no 'Y'"), ((), "expected names such as"), (7, "found 7")],
)
def test_channels_that_there_are_not(channels: Any, message: str) -> None:
    with pytest.raises(ArgumentError, match=message) as error:
        picks(TYPES["color"], RGBA, channels)
    assert error.value.parameter == "channels"


def test_as_many_names_as_channels() -> None:
    with pytest.raises(ArgumentError, match="expected 3 names for 3 channels, found R,G,B,A"):
        layout(3, None, "RGBA")
