"""Name what a file holds, its parts and layers, and what was chosen of it: pure functions on ImageSpecs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import OpenImageIO as oiio

from flowabs_nodes.errors import ReadError, likely
from flowabs_nodes.io.oiio_error import printable
from flowabs_nodes.io.views import part_view, views_in


class Selection(NamedTuple):
    """Channels to read from one part, in order: red, green, blue or one grey, then alpha if the layer has it.

    ``note`` is for the log: why these channels, where nobody asked for them. ``guessed`` is the name to ask for them
    by, where it says nothing of what they are.
    """

    part: int
    layer: str
    channels: tuple[str, ...]
    note: str = ""
    guessed: str = ""

    @property
    def grey(self) -> bool:
        """True where one channel stands for red, green and blue alike."""
        return len(self.channels) < 3

    @property
    def has_alpha(self) -> bool:
        """True where the last channel is alpha."""
        return len(self.channels) in (2, 4)


def layer_of(channel: str) -> str:
    """Return the layer of a channel: "diffuse" of "diffuse.R", "Z" of "Z", and "", the main layer, of R, G, B, A."""
    before, dot, _ = channel.rpartition(".")
    if dot:
        return before
    return "" if channel in ("R", "G", "B", "A") else channel


def part_name(spec: oiio.ImageSpec) -> str:
    """Return the name of a part; empty where it has none."""
    return spec.get_string_attribute("oiio:subimagename") or spec.get_string_attribute("name")


def parts_to_read(specs: Sequence[oiio.ImageSpec], part: str | int) -> list[int]:
    """Return the parts to look in: one by its index or name, those of a view, or all that are not deep.

    Raises ReadError where there is none.
    """
    text = str(part)
    if text:
        named = [index for index, spec in enumerate(specs) if part_name(spec) == text]
        of_view = [index for index, spec in enumerate(specs) if part_view(spec) == text and not spec.deep]
        if of_view and not named:
            return of_view
        index = named[0] if named else int(text) if text.isdecimal() else len(specs)
        if index >= len(specs):
            names = [part_name(spec) or str(index) for index, spec in enumerate(specs)]
            message = f"part {part!r} is not in the file; it has {len(specs)}: {few(names)}"
            hint = f"layer: {text!r}?" if text in views_in(specs) else likely(text, names)
            raise ReadError(message, code="no-part", hint=hint, parameter="part")
        if specs[index].deep:
            raise ReadError(f"part {part!r} is deep data, which is not read", code="deep", parameter="part")
        return [index]
    flat = [index for index, spec in enumerate(specs) if not spec.deep]
    if not flat:
        raise ReadError("deep data, which is not read; flatten it first", code="deep")
    return flat


def check_windows(specs: Sequence[oiio.ImageSpec], chosen: Sequence[Selection]) -> None:
    """Raise ReadError unless all chosen layers, which may be in several parts, are on one data window."""
    windows = {(spec.x, spec.y, spec.width, spec.height) for spec in (specs[each.part] for each in chosen)}
    if len(windows) > 1:
        names = few([each.layer for each in chosen])
        raise ReadError(f"layers {names} belong together, but have different data windows", code="window-mismatch")


def listing(specs: Sequence[oiio.ImageSpec]) -> str:
    """Return what a file holds, for messages: "it has R, G, B, A, Z", "it has ViewLayer.Combined.RGBA"."""
    if len(specs) == 1:
        return f"it has {few(_joined(specs[0].channelnames))}"
    parts = [f"{part_name(spec) or index} ({few(_joined(spec.channelnames))})" for index, spec in enumerate(specs)]
    return f"it has the parts {few(parts)}"


def _joined(channels: Iterable[str]) -> list[str]:
    """Return channels in order, those of one letter of a layer as one: "N.XYZ" for "N.X", "N.Y", "N.Z"."""
    found: dict[str, str] = {}
    for channel in channels:
        layer, dot, last = channel.rpartition(".")
        key = layer + dot if dot and len(last) == 1 else channel
        found[key] = found.get(key, key) + (last if key != channel else "")
    return list(found.values())


def few(names: Sequence[str], joint: str = ", ") -> str:
    """Return at most twelve names as a list for messages, each cut at 100 characters."""
    shown = [printable(name if len(name) < 100 else name[:97] + "...") for name in names[:12]]
    return joint.join(shown) + (f" and {len(names) - 12} more" if len(names) > 12 else "")
