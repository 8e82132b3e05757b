"""Read the ICC profile of a photograph, and make one: primaries and transfer functions of a matrix profile (ICC.1)."""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np

from flowabs_nodes.array_types import Float64
from flowabs_nodes.color.chromaticities import space_from_chromaticities
from flowabs_nodes.color.constants import BRADFORD
from flowabs_nodes.color.encoding import Encoding, Transfer
from flowabs_nodes.color.spaces import KNOWN, ColorSpace, between
from flowabs_nodes.color.transfers import Parametric, Power, Sampled
from flowabs_nodes.errors import ColorError

#: The parameters of each kind of parametric curve, in the file's order: names of :class:`Parametric`.
_PARAMETERS = ("g", "gab", "gabc", "gabcd", "gabcdef")
#: Profiles round primaries: those whose matrix to a known space is the identity within this are taken for it.
_TOLERANCE = 3e-3


def read_profile(profile: bytes, name: str) -> Encoding:
    """Return the encoding that an ICC profile describes; ``name`` is the profile's, for the log.

    Raises ColorError where it is damaged, or of a kind that is not read: tables of colours (of printers, and some
    cameras), CMYK, Lab.
    """
    try:
        return _encoding(profile, name)
    except (struct.error, IndexError, ValueError, OverflowError, ZeroDivisionError) as error:
        raise ColorError(f"damaged: {error}", code="bad-profile") from None


def _encoding(profile: bytes, name: str) -> Encoding:
    """Return the encoding of a profile; whatever goes wrong with its bytes is raised as it comes."""
    kind, connection = profile[16:20], profile[20:24]
    if kind not in (b"RGB ", b"GRAY"):
        found = kind.decode("ascii", "replace").strip()
        raise ColorError(f"it describes {found} pixels", code="bad-profile")
    tags = _tags(profile)
    if kind == b"GRAY" and b"kTRC" in tags:
        curve = _transfer(tags[b"kTRC"])
        return Encoding(f"ICC profile {name!r}", KNOWN["lin_rec709"], (curve, curve, curve))
    wanted = (b"rXYZ", b"gXYZ", b"bXYZ", b"rTRC", b"gTRC", b"bTRC")
    if connection != b"XYZ " or not all(tag in tags for tag in wanted):
        raise ColorError("it is a table of colours; only curves and primaries are read", code="bad-profile")
    columns = [np.array(struct.unpack_from(">3i", tags[tag], 8)) / 65536 for tag in wanted[:3]]
    red, green, blue = (_transfer(tags[tag]) for tag in wanted[3:])
    return Encoding(f"ICC profile {name!r}", _space(columns), (red, green, blue), profile=profile)


def _tags(profile: bytes) -> dict[bytes, bytes]:
    """Return the data of every tag by its signature."""
    (count,) = struct.unpack_from(">I", profile, 128)
    if count > 1000:
        raise ValueError(f"{count} tags")
    entries = (struct.unpack_from(">4sII", profile, 132 + 12 * i) for i in range(count))
    return {signature: profile[offset : offset + size] for signature, offset, size in entries}


def _space(columns: list[np.ndarray]) -> ColorSpace:
    """Return the space whose red, green and blue have these XYZ under D50, white adapted; a known one where it fits."""
    pairs = [tuple(xyz[:2] / xyz.sum()) for xyz in (*columns, np.sum(columns, axis=0))]
    space = space_from_chromaticities(*pairs)
    for known in KNOWN.values():
        if np.allclose(between(space, known), np.eye(3), rtol=0, atol=_TOLERANCE):
            return known
    return space


def _transfer(tag: bytes) -> Transfer:
    """Return the transfer function of a tag "curv" or "para"."""
    if tag[:4] == b"curv":
        (count,) = struct.unpack_from(">I", tag, 8)
        if count == 0:
            return Power(1.0)
        if count == 1:
            return Power(struct.unpack_from(">H", tag, 12)[0] / 256)
        values = np.frombuffer(tag, ">u2", count, 12) / 65535
        if values[-1] <= values[0]:
            raise ValueError("a curve that does not rise")
        return Sampled(tuple(values.tolist()))
    if tag[:4] == b"para":
        names = _PARAMETERS[struct.unpack_from(">H", tag, 8)[0]]
        numbers = dict(zip(names, np.array(struct.unpack_from(f">{len(names)}i", tag, 12)) / 65536, strict=True))
        curve = _parametric(names, {key: float(value) for key, value in numbers.items()})
        if not curve.g > 0 or not curve.a > 0:
            raise ValueError("a curve that does not rise")
        return curve
    raise ColorError(f"its curves are {tag[:4]!r}", code="bad-profile")


def _parametric(names: str, numbers: dict[str, float]) -> Parametric:
    """Return the function of types 0 to 4; type 1 and 2 are level below -b / a, type 2 and 3 name c otherwise."""
    if names == "gab":
        return Parametric(**numbers, d=-numbers["b"] / numbers["a"])
    if names == "gabc":  # (a x + b)^g + c above -b / a, and c below
        level = numbers.pop("c")
        return Parametric(**numbers, d=-numbers["b"] / numbers["a"], e=level, f=level)
    return Parametric(**numbers)


# ---------------------------------------------------------------------- writing


def with_profile(encoding: Encoding) -> Encoding | None:
    """Return an encoding that an ICC profile made here describes, for a file that cannot say it otherwise.

    The profile has the encoding's primaries and its transfer functions in 4096 steps. None where it cannot be said in a
    profile: a code of 1 is no linear light of 1, as in PQ, HLG and camera logs, or the light does not rise.
    """
    ramp = np.linspace(0, 1, 4096)
    curves = [transfer.linear(ramp) for transfer in encoding.transfers]
    if any(abs(each[0]) > 1e-3 or abs(each[-1] - 1) > 1e-2 or (np.diff(each) < 0).any() for each in curves):
        return None
    return read_profile(_profile(encoding.space, curves, encoding.name), encoding.name)


def _profile(space: ColorSpace, curves: Sequence[Float64], name: str) -> bytes:
    """Return the bytes of a profile of version 2 for a display of these primaries and curves."""
    text = name.encode("ascii", "replace")[:60] + b"\0"
    tags = {
        b"desc": struct.pack(">4sII", b"desc", 0, len(text)) + text + bytes(78),
        b"cprt": b"text" + bytes(4) + b"no rights reserved\0",
        b"wtpt": _xyz(_D50),
    }
    columns = to_d50(space)
    for letter, column, curve in zip((b"r", b"g", b"b"), columns.T, curves, strict=True):
        codes = np.rint(np.clip(curve, 0, 1) * 65535).astype(">u2")
        tags[letter + b"XYZ"] = _xyz(column)
        tags[letter + b"TRC"] = struct.pack(">4sII", b"curv", 0, len(codes)) + codes.tobytes()
    table, data = b"", b""
    for signature, content in tags.items():
        table += struct.pack(">4sII", signature, 132 + 12 * len(tags) + len(data), len(content))
        data += content + bytes(-len(content) % 4)
    head = struct.pack(
        ">I4xI4s4s4s12x4s28x", 132 + len(table) + len(data), 0x02100000, b"mntr", b"RGB ", b"XYZ ", b"acsp"
    )
    return (head + _xyz(_D50)[8:]).ljust(128, b"\0") + struct.pack(">I", len(tags)) + table + data


#: XYZ of the white of profiles.
_D50 = np.array([0.9642, 1.0, 0.8249])


def _xyz(values: Float64) -> bytes:
    """Return a tag "XYZ " of three numbers."""
    return struct.pack(">4sI3i", b"XYZ ", 0, *(round(65536 * float(value)) for value in values))


def to_d50(space: ColorSpace) -> Float64:
    """Return the matrix (3, 3) from RGB of a space to XYZ under D50, white adapted by Bradford."""
    bradford = np.array(BRADFORD).reshape(3, 3)
    matrix = np.array(space.to_xyz).reshape(3, 3)
    scale = (bradford @ _D50) / (bradford @ matrix.sum(axis=1))
    return np.asarray(np.linalg.solve(bradford, scale[:, None] * bradford @ matrix))
