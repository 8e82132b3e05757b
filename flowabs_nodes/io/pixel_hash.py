"""Hash the pixels of a file, so that a later run sees whether any of them has changed.

OpenEXR has no checksum over pixels that are not compressed, and few errors show in PIZ or DWA. Other metadata than the
pixels' does not count: what somebody writes into a header later leaves the hash as it is.

Of an EXR the bytes of its chunks are hashed as they are stored, lossy or not, since what a lossy codec makes of them
may differ by a bit from one processor to another. Of other formats the decoded values are.
"""

from __future__ import annotations

import hashlib
import io
import os
import struct
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

_BYTES = 20
_BLOCK = 1 << 20
#: What stands in a header until the hash is known.
PLACE = "0" * (2 * _BYTES)

_MULTIPART = 1 << 12
_MAGIC = 20000630


class DecodedHash:
    """The hash of a picture's decoded values, given in order, band of rows by band of rows."""

    def __init__(self, width: int, height: int, channels: int) -> None:
        self._hash = hashlib.blake2b(f"{width} {height} {channels}".encode(), digest_size=_BYTES)

    def update(self, rows: npt.NDArray[Any]) -> None:
        """Add rows, (H, W, C), in the file's own data type."""
        little_endian = rows.dtype.newbyteorder("<")
        self._hash.update(np.ascontiguousarray(rows, little_endian).data)

    def hexdigest(self) -> str:
        """Return the hash as 40 hexadecimal digits."""
        return self._hash.hexdigest()


def decoded_hash(pixels: npt.NDArray[Any]) -> str:
    """Return the hash of a whole picture, (H, W, C), that a file holds as it is."""
    height, width, channels = pixels.shape
    whole = DecodedHash(width, height, channels)
    whole.update(pixels)
    return whole.hexdigest()


def chunk_hash(file: BinaryIO) -> str:
    """Return the hash of the chunks of an EXR, all parts: of all bytes from the first chunk on.

    Raises ValueError where the file is no EXR, or its first chunk is not there.
    """
    file.seek(_first_chunk(file))
    whole = hashlib.blake2b(digest_size=_BYTES)
    while block := file.read(_BLOCK):  # hashlib.file_digest takes all of a BytesIO, wherever it stands
        whole.update(block)
    return whole.hexdigest()


def sign_exr(stream: io.BytesIO, name: str) -> None:
    """Put the hash of an EXR's chunks into its string attribute ``name``, which holds :data:`PLACE` until then."""
    value, first = chunk_hash(stream).encode("ascii"), _first_chunk(stream)
    start = name.encode("ascii") + b"\0string\0" + struct.pack("<i", len(PLACE))
    with stream.getbuffer() as data:
        place = bytes(data[:first]).index(start + PLACE.encode("ascii")) + len(start)
        data[place : place + len(value)] = value


def _first_chunk(file: BinaryIO) -> int:
    """Return where an EXR's first chunk begins: what the table behind the headers says. Raises ValueError."""
    size = file.seek(0, os.SEEK_END)
    file.seek(0)
    try:
        magic, version = struct.unpack("<II", file.read(8))
        if magic != _MAGIC:
            raise ValueError("no EXR")
        while _skip_header(file, size) and version & _MULTIPART:
            pass
        (first,) = struct.unpack("<Q", file.read(8))
    except struct.error as error:
        raise ValueError("cut short") from error
    if not file.tell() <= first < size:
        raise ValueError("no first chunk")
    return int(first)


def _skip_header(file: BinaryIO, size: int) -> int:
    """Go behind a part's header; return how many attributes it has: none behind the last header of several parts."""
    count = 0
    while _text(file):
        _text(file)  # the type
        (length,) = struct.unpack("<i", file.read(4))
        if not 0 <= length <= size:
            raise ValueError("an attribute longer than the file")
        file.seek(length, os.SEEK_CUR)
        count += 1
    return count


def _text(file: BinaryIO) -> bytes:
    """Read a name up to its zero byte. Raises ValueError where it has none."""
    text = bytearray()
    while (byte := file.read(1)) != b"\0":
        if not byte or len(text) > 255:
            raise ValueError("a name without an end")
        text += byte
    return bytes(text)
