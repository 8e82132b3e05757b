"""The types of pictures that nodes exchange (docs/numbers.md), and the channels of each."""

from __future__ import annotations

from typing import Literal

PortType = Literal["color", "mono", "matte", "flow", "data"]
PORT_TYPES: tuple[PortType, ...] = ("color", "mono", "matte", "flow", "data")

#: The sets of channel names that each type may have, in the order of the pixels' last axis; ``data`` has any channels.
CHANNELS: dict[str, tuple[tuple[str, ...], ...]] = {
    "color": (("R", "G", "B"), ("R", "G", "B", "A")),
    "mono": (("Y",),),
    "matte": (("Y",),),
    "flow": (("flow.x", "flow.y"),),
}


def channel_names(type: str, count: int) -> tuple[str, ...] | None:
    """Return the names of a picture's ``count`` channels; None where the type does not tell."""
    return next((names for names in CHANNELS.get(type, ()) if len(names) == count), None)


def expected_channels(type: str, prefix: str = "") -> str:
    """Return the channel names that a picture of that type may have, for error messages: "R,G,B or R,G,B,A"."""
    return " or ".join(",".join(prefix + name for name in names) for names in CHANNELS[type])
