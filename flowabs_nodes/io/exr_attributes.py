"""Read an EXR's header byte by byte, as values of which the OpenEXR module writes the same bytes again.

The module's own reading changes some values, 24000/1000 to 24/1, and reads no header at all that has a key code, a
fraction or a text which the standard forbids.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import OpenEXR

from flowabs_nodes.errors import ReadError
from flowabs_nodes.image.header_text import readable
from flowabs_nodes.io.formats.exr import next_attribute
from flowabs_nodes.io.oiio_error import printable


def stored_header(path: str, part: int) -> tuple[dict[str, Any], list[str]]:
    """Return the attributes of a part, name -> value, and the names of those that the OpenEXR module cannot write.

    A text that is no UTF-8 is taken for Latin-1. Only for a file that OpenImageIO has opened: nothing else is checked.
    Raises ReadError where the file is cut short, or has no such part.
    """
    header: dict[str, Any] = {}
    left_out: list[str] = []
    for name, kind, data in _attributes(path, part):
        try:
            text, type = name.decode("utf-8"), kind.decode("ascii")
            if type != _FIXED.get(text, type):
                raise ValueError(f"{text} is of type {_FIXED[text]}")
            header[text] = _value(type, data)
        except (UnicodeDecodeError, struct.error, ValueError, TypeError):
            left_out.append(printable(name.decode("utf-8", "replace")))
    if not {"dataWindow", "displayWindow"} <= header.keys():
        raise ReadError("damaged: no windows in its header", code="damaged", file=path)
    return header, left_out


def _attributes(path: str, part: int) -> list[tuple[bytes, bytes, bytes]]:
    """Return name, type and value of every attribute of a part, as they are stored."""
    found = []
    with open(path, "rb") as file:
        size = os.fstat(file.fileno()).st_size
        file.seek(8)
        for index in range(part + 1):
            while (attribute := next_attribute(file)) is not None:
                name, kind, length = attribute
                if file.tell() + length > size:
                    raise ReadError("damaged: an attribute longer than the file", code="damaged", file=path)
                if index == part:
                    found.append((name, kind, file.read(length)))
                else:
                    file.seek(length, os.SEEK_CUR)
    return found


def _value(kind: str, data: bytes) -> Any:
    """Return the value that the OpenEXR module writes as these bytes. Raises ValueError and its like for none."""
    if len(data) != _SIZES.get(kind, len(data)):
        raise ValueError(f"{kind} takes {_SIZES[kind]} bytes")
    make = _TYPES.get(kind)
    return make(data) if make is not None else OpenEXR.OpaqueAttribute(data, kind)


def _one(format: str) -> Callable[[bytes], Any]:
    """Return a function that reads a single number."""
    return lambda data: struct.unpack(format, data)[0]


def _array(dtype: str, *shape: int) -> Callable[[bytes], Any]:
    """Return a function that reads a vector or a matrix."""
    return lambda data: np.frombuffer(data, dtype).reshape(shape).astype(dtype[1:])


def _box(dtype: str) -> Callable[[bytes], Any]:
    """Return a function that reads the first and the last corner of a box."""
    corners = _array(dtype, 2, 2)
    return lambda data: tuple(corners(data))


def _texts(data: bytes) -> Any:
    """Return several texts: as a list of those that are UTF-8, for names of views; else as they are stored."""
    texts, at = [], 0
    while at < len(data):
        (length,) = struct.unpack_from("<I", data, at)
        texts.append(data[at + 4 : at + 4 + length])
        at += 4 + length
    if at != len(data):
        raise ValueError("its texts are longer than it is")
    try:
        return [text.decode("utf-8") for text in texts]
    except UnicodeDecodeError:
        return OpenEXR.OpaqueAttribute(data, "stringvector")


def _choice(make: Callable[[int], Any], count: int) -> Callable[[bytes], Any]:
    """Return a function that reads one of ``count`` choices; a file with another one cannot be read again."""

    def read(data: bytes) -> Any:
        (number,) = data
        if number >= count:
            raise ValueError(f"{number} is none of {count} choices")
        return make(number)

    return read


def _line_order(data: bytes) -> Any:
    """Return an order of lines as it is stored."""
    _choice(int, 3)(data)
    return OpenEXR.OpaqueAttribute(data, "lineOrder")


def _tiles(data: bytes) -> Any:
    """Return a description of tiles."""
    tiles = OpenEXR.TileDescription()
    tiles.xSize, tiles.ySize, mode = struct.unpack("<IIB", data)
    tiles.mode = _choice(OpenEXR.LevelMode, 3)(bytes([mode & 15]))
    tiles.roundingMode = _choice(OpenEXR.LevelRoundingMode, 2)(bytes([mode >> 4]))
    return tiles


#: How many bytes a value of a type has that is written as it is stored.
_SIZES = {"rational": 8, "timecode": 8, "keycode": 28, "lineOrder": 1}
#: Attributes that no reader takes, or no writer writes, with another type than the standard's.
_FIXED = {
    **dict.fromkeys(("adoptedNeutral", "cameraColorBalance", "sensorCenterOffset", "sensorOverallDimensions"), "v2f"),
    **dict.fromkeys(("originalDataWindow", "sensorAcquisitionRectangle"), "box2i"),
    **dict.fromkeys(("name", "view", "colorInteropID"), "string"),
    **dict.fromkeys(("pixelAspectRatio", "screenWindowWidth"), "float"),
    "screenWindowCenter": "v2f",
    "multiView": "stringvector",
    "chromaticities": "chromaticities",
    "envmap": "envmap",
}
#: Types of which the OpenEXR module writes only its own values -> how to make one. All others are written as they are
#: stored: fractions, time and key codes, and types that nobody knows.
_TYPES: dict[str, Callable[[bytes], Any]] = {
    "int": _one("<i"),
    "float": _one("<f"),
    "double": _array("<f8", 1),
    "string": readable,
    "stringvector": _texts,
    "chromaticities": lambda data: struct.unpack("<8f", data),
    "box2i": _box("<i4"),
    "box2f": _box("<f4"),
    **{
        f"v{size}{letter}": _array(dtype, size)
        for size in (2, 3)
        for letter, dtype in zip("ifd", ("<i4", "<f4", "<f8"), strict=True)
    },
    **{
        f"m{size}{size}{letter}": _array(dtype, size, size)
        for size in (3, 4)
        for letter, dtype in zip("fd", ("<f4", "<f8"), strict=True)
    },
    "compression": _choice(OpenEXR.Compression, int(OpenEXR.NUM_COMPRESSION_METHODS)),
    "envmap": _choice(OpenEXR.Envmap, int(OpenEXR.NUM_ENVMAPTYPES)),
    "lineOrder": _line_order,
    "tiledesc": _tiles,
    "chlist": lambda data: None,  # the encoder makes it
}
