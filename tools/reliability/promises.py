"""What is promised of an EXR that goes through a graph (docs/exr.md), each promise as a function on both ends.

A function returns None where the plate has nothing of the kind, "" where all is kept, or what is broken.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from flowabs_nodes.image import Origin
from tools.reliability.exr_facts import Attribute, Part, same_bits

#: Attributes that say how a file stores its pixels. Those of windows and compression have promises of their own.
_STORAGE = frozenset(
    (
        *("channels", "chunkCount", "compression", "dataWindow", "displayWindow", "dwaCompressionLevel", "lineOrder"),
        *("maxSamplesPerPixel", "preview", "tiles", "type", "version", "zipCompressionLevel"),
    )
)
_COLOR = ("chromaticities", "colorInteropID", "adoptedNeutral", "whiteLuminance")
_TIME = ("timeCode", "keyCode", "framesPerSecond", "captureRate")
_SHAPE = ("pixelAspectRatio", "screenWindowCenter", "screenWindowWidth")
#: Luminance and chroma, which are read as one picture: R, G, B are made of them.
_LUMINANCE_CHROMA = ("Y", "RY", "BY")
#: Attributes that all parts of a file have in common: those of the part that was read count for all.
_SHARED = ("pixelAspectRatio", "timeCode", "chromaticities")
#: Compressions that give back every bit, of any channel; pxr24 does of halves.
_LOSSLESS = ("none", "rle", "zips", "zip", "piz", "zstd", "htj2k256", "htj2k32")


@dataclass(frozen=True)
class Passage:
    """A plate that went through a graph: both files, and what was said.

    ``origin`` is the part and the channels that were read. ``way``: they were read as colours, which stay the "same" or
    are "changed", or as "data". ``spaces`` are the colour spaces in which the plate and the file made of it are read.
    """

    before: tuple[Part, ...]
    after: tuple[Part, ...]
    origin: Origin
    way: Literal["same", "changed", "data"]
    notes: tuple[str, ...]
    warnings: tuple[str, ...]
    spaces: tuple[str, str]

    @property
    def plate(self) -> Part:
        """Return the plate's part that was read."""
        return self.before[self.origin.part]

    @property
    def made(self) -> Part:
        """Return the part that was made of it, which is the first."""
        return self.after[0]

    @property
    def others(self) -> list[tuple[Part, Part | None]]:
        """Return the plate's other parts, deep ones aside, each with the one of its name that was written."""
        written = {part.name: part for part in self.after[1:]}
        return [
            (part, written.get(part.name))
            for index, part in enumerate(self.before)
            if index != self.origin.part and not part.deep
        ]


def display_window(passage: Passage) -> str | None:
    """The display window is the plate's."""
    return _equal("display window", *(each.window("displayWindow") for each in (passage.plate, passage.made)))


def data_window(passage: Passage) -> str | None:
    """The data window is the plate's, overscan and negative corners included."""
    return _equal("data window", *(each.window("dataWindow") for each in (passage.plate, passage.made)))


def pixel_aspect(passage: Passage) -> str | None:
    """The pixels have the plate's shape, and the screen window its place."""
    return _attributes(passage, _SHAPE)


def chromaticities(passage: Passage) -> str | None:
    """What the header says of colours stays as it is, since the colours do."""
    return _attributes(passage, _COLOR)


def time_code(passage: Passage) -> str | None:
    """Time code, key code and frame rate are those of the plate."""
    return _attributes(passage, _TIME)


def attributes(passage: Passage) -> str | None:
    """All other attributes stay, name, type and every byte, also of types that nobody knows; none is added."""
    known = {*_STORAGE, *_COLOR, *_TIME, *_SHAPE, "name"}
    if passage.plate.compression != "none":
        known.add("acesImageContainerFlag")  # which is not true there
    names = {name for part in (passage.plate, passage.made) for name in part.header if not name.startswith("flowabs:")}
    return _attributes(passage, sorted(names - known))


def alpha(passage: Passage) -> str | None:
    """The alpha has the plate's bits, also one that was passed over since it is 0 in every pixel."""
    name = passage.origin.alpha or next((name for name in passage.origin.channels if _last(name) == "A"), "")
    if not name or name not in passage.plate.channels or passage.way == "data":
        return None
    if "A" not in passage.made.channels:
        return "there is no A"
    return _came_back(passage, name, "A")


def colors(passage: Passage) -> str | None:
    """What no node changed comes back bit for bit, in the plate's type, the widest where its channels have several."""
    data = passage.way == "data"
    read = [name for name in passage.origin.channels if name in passage.plate.channels and (data or _last(name) != "A")]
    if passage.way == "changed" or not read:
        return None
    targets = read if data else ["R", "G", "B"]
    for source, target in zip(read if data else (read * 3)[:3], targets, strict=True):
        if target not in passage.made.channels:
            return f"there is no {target}"
        if said := _came_back(passage, source, target):
            return said
    return ""


def layers(passage: Passage) -> str | None:
    """With ``keep_layers`` "*", all other channels and parts come back bit for bit: half, float and uint."""
    read = {*passage.origin.channels, passage.origin.alpha}
    if set(_LUMINANCE_CHROMA) <= set(passage.plate.channels):
        read |= set(_LUMINANCE_CHROMA)
    own = [name for name in passage.plate.channels if name not in read]
    pairs = [(passage.plate, passage.made, name) for name in own]
    for part, written in passage.others:
        if written is None:
            return f"there is no part {part.name}"
        pairs += [(part, written, name) for name in part.channels]
        if said := _same_header(part, written, passage):
            return f"part {part.name}: {said}"
    if not pairs:
        return None
    for part, written, name in pairs:
        if name not in written.channels:
            return f"there is no channel {name}"
        if not same_bits(part.channels[name], written.channels[name]):
            return _differs(part, written, name, name)
    return ""


def color_space(passage: Passage) -> str | None:
    """The log says where the colour space comes from, and the file that is written is read in the same one."""
    if passage.way == "data":
        return None
    if not any("colour space" in note for note in passage.notes):
        return "the log does not say which colour space"
    return _equal("colour space", *passage.spaces)


def compression(passage: Passage) -> str | None:
    """Each part has the compression of the plate's where that loses nothing, else zip: DWA and B44 are never kept."""
    pairs = [(passage.plate, passage.made)] + [(part, written) for part, written in passage.others if written]
    for part, written in pairs:
        half = all(str(plane.dtype) != "float32" for plane in written.channels.values())
        kept = part.compression in _LOSSLESS or (part.compression == "pxr24" and half)
        if said := _equal("compression", part.compression if kept else "zip", written.compression):
            return said
    return ""


#: Every promise by the name that tables give it.
PROMISES: dict[str, Callable[[Passage], str | None]] = {
    "display window": display_window,
    "data window": data_window,
    "pixel aspect": pixel_aspect,
    "chromaticities": chromaticities,
    "time code": time_code,
    "attributes": attributes,
    "alpha": alpha,
    "colours": colors,
    "layers": layers,
    "colour space": color_space,
    "compression": compression,
}


def _last(channel: str) -> str:
    """Return "A" of any spelling of an alpha, else the last part of a channel's name."""
    last = channel.rpartition(".")[2]
    return "A" if last.lower() in ("a", "alpha") else last


def _equal(what: str, before: object, after: object) -> str:
    """Return "" for equals, else what they are."""
    return "" if before == after else f"{what} {before} became {after}"


def _attributes(passage: Passage, names: Iterable[str]) -> str | None:
    """Compare some attributes of both headers; None where neither has one that says anything."""
    before, after = passage.plate.header, passage.made.header
    there = [name for name in names if name in before or name in after]
    for name in there:
        if name not in after and any("left out" in warning and name in warning for warning in passage.warnings):
            continue  # a value that no EXR may have, as the log says
        if _readable(before.get(name)) != after.get(name):
            return f"{name} {before.get(name)} became {after.get(name)}"
    plain = {"pixelAspectRatio": struct.pack("<f", 1), "screenWindowWidth": struct.pack("<f", 1)}
    plain["screenWindowCenter"] = struct.pack("<2f", 0, 0)
    return "" if any(before[name].value != plain.get(name) for name in there) else None


def _readable(attribute: Attribute | None) -> Attribute | None:
    """Return an attribute as it must be written: a text that is no UTF-8 becomes so, taken for Latin-1."""
    if attribute is None or attribute.type != "string":
        return attribute
    try:
        attribute.value.decode("utf-8")
    except UnicodeDecodeError:
        return attribute._replace(value=attribute.value.decode("latin-1").encode("utf-8"))
    return attribute


def _same_header(part: Part, written: Part, passage: Passage) -> str:
    """Compare the headers of a part that is kept and of what was written of it."""
    for name in sorted({*part.header, *written.header} - _STORAGE):
        expected = passage.made.header.get(name) if name in _SHARED else part.header.get(name)
        if written.header.get(name) != expected:
            return f"{name} {expected} became {written.header.get(name)}"
    return _equal("data window", part.window("dataWindow"), written.window("dataWindow"))


def _came_back(passage: Passage, source: str, target: str) -> str:
    """Compare a channel that was read with what was written of it; NaN and Inf of colours are repaired."""
    read = [plane for name, plane in passage.plate.channels.items() if name in passage.origin.channels]
    kind = np.float16 if all(plane.dtype == np.float16 for plane in read) else np.float32
    before, after = passage.plate.channels[source].astype(kind), passage.made.channels[target]
    finite = np.isfinite(before) | (passage.way == "data")
    same = after.dtype == kind and after.shape == before.shape and same_bits(before[finite], after[finite])
    return "" if same else _differs(passage.plate, passage.made, source, target)


def _differs(before: Part, after: Part, source: str, target: str) -> str:
    """Say of two planes that they are not the same."""
    one, other = before.channels[source], after.channels[target]
    if one.dtype != other.dtype or one.shape != other.shape:
        return f"{source}, {one.dtype} {one.shape}, became {target}, {other.dtype} {other.shape}"
    return f"{source}: {int((one != other).sum())} pixels differ"
