"""JPEG: sRGB, read only, since saving one changes its pixels."""

from __future__ import annotations

import os
import struct

from flowabs_nodes.errors import ReadError
from flowabs_nodes.io.formats.declare import Format

#: Frames that are coded by Huffman: baseline, extended, progressive. Arithmetic coding may be shorter.
_HUFFMAN = (0xC0, 0xC1, 0xC2)
_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
#: Pixels for a byte, at most: each block of 8 x 8 takes a bit or more.
_PIXELS_PER_BYTE = 8 * 64


def _look(path: str) -> None:
    """Refuse a file that is too short for as many pixels as it says; the decoder would make them up, grey."""
    with open(path, "rb") as file:
        file.seek(2)
        while len(head := file.read(4)) == 4 and head[0] == 0xFF:
            marker, length = struct.unpack(">xBH", head)
            if marker in _FRAMES:
                frame = file.read(5)
                if marker in _HUFFMAN and len(frame) == 5:
                    height, width = struct.unpack(">xHH", frame)
                    if width * height > _PIXELS_PER_BYTE * os.fstat(file.fileno()).st_size:
                        message = f"damaged or cut short: too few bytes for {width}x{height} pixels"
                        raise ReadError(message, code="damaged", file=path)
                return
            file.seek(max(0, length - 2), 1)


JPEG = Format(
    name="JPEG",
    oiio_name="jpeg",
    extensions=(".jpg", ".jpeg"),
    magic=(b"\xff\xd8\xff",),
    display_referred=True,
    look=_look,
    storage=("jpeg:",),
)
