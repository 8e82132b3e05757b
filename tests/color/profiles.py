"""Make ICC profiles for tests, byte by byte: matrix and curves of a display, or one curve of grey."""

from __future__ import annotations

import struct
from collections.abc import Sequence

import colour
import numpy as np


def curve(gamma: float | Sequence[float]) -> bytes:
    """Return a "curv": a power, or equal steps of linear light."""
    if isinstance(gamma, float):
        return struct.pack(">4sIIH2x", b"curv", 0, 1, round(gamma * 256))
    values = [round(65535 * value) for value in gamma]
    return struct.pack(f">4sII{len(values)}H", b"curv", 0, len(values), *values)


def parametric(kind: int, *numbers: float) -> bytes:
    """Return a "para" of a kind from 0 to 4."""
    fixed = [round(65536 * number) for number in numbers]
    return struct.pack(f">4sIHxx{len(fixed)}i", b"para", 0, kind, *fixed)


SRGB_CURVE = parametric(3, 2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045)


def profile(space: str = "sRGB", curves: bytes | Sequence[bytes] = SRGB_CURVE, kind: bytes = b"RGB ") -> bytes:
    """Return a profile of one of colour-science's RGB spaces, its primaries under D50 by Bradford."""
    rgb = colour.RGB_COLOURSPACES[space]
    d50 = colour.CCS_ILLUMINANTS["CIE 1931 2 Degree Standard Observer"]["D50"]
    white = colour.xy_to_XYZ(rgb.whitepoint)
    adapt = colour.adaptation.matrix_chromatic_adaptation_VonKries(white, colour.xy_to_XYZ(d50), transform="Bradford")
    columns = (adapt @ rgb.matrix_RGB_to_XYZ).T
    tags: dict[bytes, bytes] = {}
    each = [curves] * 3 if isinstance(curves, bytes) else list(curves)
    if kind == b"GRAY":
        tags[b"kTRC"] = each[0]
    elif kind == b"RGB ":
        for letter, xyz, one in zip("rgb", columns, each, strict=True):
            fixed = [round(65536 * float(number)) for number in xyz]
            tags[f"{letter}XYZ".encode()] = struct.pack(">4sI3i", b"XYZ ", 0, *fixed)
            tags[f"{letter}TRC".encode()] = one
    description = b"made\0"
    tags[b"desc"] = struct.pack(">4sII", b"desc", 0, len(description)) + description + b"\0" * 78
    return _file(tags, kind)


def _file(tags: dict[bytes, bytes], kind: bytes) -> bytes:
    offset, table, data = 132 + 12 * len(tags), b"", b""
    for name, content in tags.items():
        padded = content + b"\0" * (-len(content) % 4)
        table += struct.pack(">4sII", name, offset + len(data), len(content))
        data += padded
    size = offset + len(data)
    head = struct.pack(">I4xI4s4s4s12x4s", size, 0x02100000, b"mntr", kind, b"XYZ ", b"acsp")
    head = head.ljust(68, b"\0") + struct.pack(">3i", 63190, 65536, 54061)  # D50
    return head.ljust(128, b"\0") + struct.pack(">I", len(tags)) + table + data


def table_profile() -> bytes:
    """Return a profile of a printer's kind: a table of colours, without primaries."""
    return _file({b"A2B0": b"mft1" + b"\0" * 60}, b"RGB ")


RAMP = np.linspace(0, 1, 33)
