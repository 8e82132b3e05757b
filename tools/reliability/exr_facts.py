"""Read what an EXR holds without the code that is on trial: headers byte by byte, pixels by the OpenEXR module."""

from __future__ import annotations

import contextlib
import io
import os
import struct
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy.typing as npt
import OpenEXR

#: Compressions in the order of the numbers that a header holds.
COMPRESSIONS = (
    *("none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"),
    *("htj2k256", "htj2k32", "zstd"),
)
_MULTIPART = 1 << 12
_PLACES = ("name", "type", "view", "chunkCount")
_DEEP = (b"deepscanline", b"deeptile")


class Attribute(NamedTuple):
    """An attribute as it is stored: the name of its type, and the bytes of its value."""

    type: str
    value: bytes


@dataclass(frozen=True)
class Part:
    """One part of a file; ``channels`` are planes (H, W) in the file's own data types, none of deep data."""

    header: Mapping[str, Attribute]
    channels: Mapping[str, npt.NDArray[Any]]

    @property
    def name(self) -> str:
        """Return the part's name; "" where it has none."""
        return self.text("name")

    @property
    def deep(self) -> bool:
        """Return whether the part holds deep data."""
        return "type" in self.header and self.header["type"].value in _DEEP

    @property
    def compression(self) -> str:
        """Return the compression, such as "zip"."""
        return COMPRESSIONS[self.header["compression"].value[0]]

    def text(self, name: str) -> str:
        """Return a text of the header; "" where there is none."""
        found = self.header.get(name)
        return found.value.decode("utf-8", "replace") if found else ""

    def window(self, name: str) -> tuple[int, ...]:
        """Return the first and the last pixel of a window: x, y, x, y."""
        return struct.unpack("<4i", self.header[name].value)


def read_parts(path: str | os.PathLike[str]) -> tuple[Part, ...]:
    """Return every part of a file. Raises RuntimeError, ValueError or TypeError where the OpenEXR module cannot."""
    headers = read_headers(path)
    if all(Part(header, {}).deep for header in headers):
        return tuple(Part(header, {}) for header in headers)
    with contextlib.redirect_stdout(io.StringIO()), tempfile.TemporaryDirectory() as folder:  # it prints warnings
        try:
            read = OpenEXR.File(os.fspath(path), separate_channels=True).parts
        except (ArithmeticError, RuntimeError, ValueError):  # of attributes that have nothing to do with pixels
            plain = os.path.join(folder, "plain.exr")
            _without_meaning(path, plain)
            read = OpenEXR.File(plain, separate_channels=True).parts
    if len(read) != len(headers):
        raise ValueError(f"OpenEXR reads {len(read)} of {len(headers)} parts")
    parts = []
    for header, part in zip(headers, read, strict=True):
        planes = {} if Part(header, {}).deep else {name: each.pixels for name, each in part.channels.items()}
        parts.append(Part(header, planes))
    return tuple(parts)


def _without_meaning(path: str | os.PathLike[str], copy: str) -> None:
    """Copy a file with types that nobody knows in place of fractions, texts and the like, which OpenEXR may refuse."""
    with open(path, "rb") as file:
        data = bytearray(file.read())
    for header in read_headers(path):
        for name, attribute in header.items():
            if attribute.type in ("rational", "keycode", "timecode", "string", "stringvector") and name not in _PLACES:
                start = name.encode("latin-1") + b"\0"
                place = data.index(start + attribute.type.encode() + b"\0") + len(start)
                data[place : place + 1] = b"x"
    with open(copy, "wb") as file:
        file.write(data)


def read_headers(path: str | os.PathLike[str]) -> tuple[Mapping[str, Attribute], ...]:
    """Return the attributes of every part of a file, by name, whatever their types. Raises ValueError for no EXR."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:4] != b"\x76\x2f\x31\x01":
        raise ValueError("no EXR")
    several = struct.unpack("<I", data[4:8])[0] & _MULTIPART
    headers: list[Mapping[str, Attribute]] = []
    at = 8
    while not headers or (several and data[at : at + 1] != b"\0"):
        header, at = _header(data, at)
        headers.append(header)
    return tuple(headers)


def _header(data: bytes, at: int) -> tuple[Mapping[str, Attribute], int]:
    """Return the attributes of the part that begins at a byte, and where the next part begins."""
    found: dict[str, Attribute] = {}
    while data[at] != 0:
        name, at = _text(data, at)
        kind, at = _text(data, at)
        (size,) = struct.unpack("<I", data[at : at + 4])
        found[name] = Attribute(kind, data[at + 4 : at + 4 + size])
        at += 4 + size
    return found, at + 1


def _text(data: bytes, at: int) -> tuple[str, int]:
    """Return the text that begins at a byte, and where it is over."""
    end = data.index(b"\0", at)
    return data[at:end].decode("latin-1"), end + 1


def same_bits(one: npt.NDArray[Any], other: npt.NDArray[Any]) -> bool:
    """Return whether shape, data type and every bit are equal."""
    return one.dtype == other.dtype and one.shape == other.shape and one.tobytes() == other.tobytes()
