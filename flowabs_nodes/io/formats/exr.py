"""OpenEXR: scene-linear, premultiplied, any number of layers and parts. Written by the OpenEXR module."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import TYPE_CHECKING, BinaryIO

from flowabs_nodes.errors import ReadError
from flowabs_nodes.io.formats.declare import Format
from flowabs_nodes.io.limits import MAX_CHANNELS

if TYPE_CHECKING:
    import OpenImageIO as oiio


def _reader(specs: Sequence[oiio.ImageSpec], problem: str) -> str:
    """Return who reads luminance and chroma: subsampled, OpenImageIO refuses it, or (3.0) opens but cannot read it."""
    chroma = len(specs) == 1 and {"Y", "RY", "BY"} <= set(specs[0].channelnames)
    return "flowabs_nodes.io.luminance_chroma:LuminanceChromaFile" if chroma or "ubsampled" in problem else ""


#: The most bytes of a name, of an attribute or a channel, and of what follows a channel's name.
_NAME = 256
_CHANNEL = 16


def _look(path: str) -> None:
    """Refuse a file of too many channels; OpenImageIO takes 11 s to open one of 100,000."""
    with open(path, "rb") as file:
        file.seek(8)
        while (attribute := next_attribute(file)) is not None:
            name, _, length = attribute
            if name == b"channels":
                found = _count_channels(file.read(min(length, MAX_CHANNELS * (_NAME + _CHANNEL))))
                if found > MAX_CHANNELS or length > MAX_CHANNELS * (_NAME + _CHANNEL):
                    message = f"a picture of more than {MAX_CHANNELS:,} channels is not opened"
                    raise ReadError(message, code="too-large", file=path)
                return  # of the first part
            file.seek(length, 1)


def next_attribute(file: BinaryIO) -> tuple[bytes, bytes, int] | None:
    """Return name, type and size of a header's next attribute, and go to its value.

    At the end of the header the file stands behind it, where that of the next part begins, and None is returned; None
    too where there is no attribute.
    """
    start = file.tell()
    head = file.read(2 * _NAME + 4)
    name, _, rest = head.partition(b"\0")
    kind, end, rest = rest.partition(b"\0")
    if not name or not end or len(rest) < 4:
        file.seek(start + 1)
        return None
    file.seek(start + len(name) + len(kind) + 6)
    return name, kind, struct.unpack("<I", rest[:4])[0]


def _count_channels(channels: bytes) -> int:
    """Return how many channels the value of the attribute "channels" lists."""
    count = at = 0
    while (end := channels.find(b"\0", at)) > at:
        count, at = count + 1, end + 1 + _CHANNEL
    return count


EXR = Format(
    name="EXR",
    article="an",
    oiio_name="openexr",
    extensions=(".exr",),
    magic=(b"\x76\x2f\x31\x01",),
    oriented=False,  # an "Orientation" there is only somebody's attribute
    integers="exact",
    reader=_reader,
    look=_look,
    decoder="flowabs_nodes.io.decode_exr:decode_exr",
    encoder="flowabs_nodes.io.encode_exr:encode_exr",
    data_types=("half", "float"),
    layers=True,
    hashed="stored",
    storage=("openexr:",),
)
