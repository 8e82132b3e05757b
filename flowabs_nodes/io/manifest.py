"""Names of objects for ids: the manifest that a Cryptomatte brings along, and the hash that its ids are made by.

``read_id`` leaves the header's attributes on its images: ``cryptomatte/KEY/name``, and as ``cryptomatte/KEY/manifest``
a JSON object from names to ids in hexadecimal. Where a file has no manifest (it may be too long, or in a file beside),
the id of a name is known all the same: MurmurHash3 of it, 32 bits, with a bit of the exponent turned where the number
would be no normal float (Psyop's Cryptomatte specification 1.2).
"""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

import OpenImageIO as oiio

from flowabs_nodes.errors import ArgumentError, nearest
from flowabs_nodes.io import cryptomatte

#: The least number that is an id.
_IDS = 2**32


class Manifest(NamedTuple):
    """The ids of names; no names where the file says none."""

    ids: Mapping[str, int]
    note: str = ""  # what is wrong with the one in the file


def manifest_of(spec: oiio.ImageSpec, layer: str = "") -> Manifest:
    """Return the names of the ids of an image with the header ``spec``, which were read from ``layer``.

    Where the header has several Cryptomattes it is that of the layer; where the layer is none of theirs, all together:
    the same name has the same id in each.
    """
    known = cryptomatte.declared([spec])
    own = [name for name in known if layer.startswith(name)]
    names = [max(own, key=len)] if own else list(known)
    found: dict[str, int] = {}
    note = ""
    for name in names:
        text = next((str(value) for key, value in known[name].items() if key.endswith("/manifest")), "{}")
        try:
            found |= {str(each): int(str(number), 16) % _IDS for each, number in json.loads(text).items()}
        except (ValueError, AttributeError) as error:
            note = f"the manifest of {name} cannot be read ({error}): ids are computed from the names"
    return Manifest(found, note)


def ids_named(names: str, known: Mapping[str, int], unsure: Callable[[str, int], None]) -> list[int]:
    """Return the ids that a list of names stands for.

    Parameters
    ----------
    names
        Names between commas, one with a comma in quotes; in a name ``*`` stands for any letters and ``?`` for one. An
        id itself may stand for a name: decimal, or hexadecimal after 0x. A name of the manifest comes before a number.
    known
        The manifest. Without one the id of a name is its hash, and ``unsure`` is told both.

    Raises
    ------
    ArgumentError
        A name that is not in the manifest, one with a wildcard that fits none, one with a wildcard without a manifest,
        or no name at all.
    """
    found: list[int] = []
    for name in _listed(names):
        number = _number(name)
        if name in known:
            found.append(known[name])
        elif number is not None:
            found.append(number)
        elif "*" in name or "?" in name:
            found += _fitting(name, known)
        elif known:
            raise _unknown(f"there is no object {name!r}", name, known)
        else:
            found.append(cryptomatte_id(name))
            unsure(name, found[-1])
    if not found:
        raise ArgumentError("expected a name, found none", hint='"*" is everything', parameter="names")
    return found


def _listed(names: str) -> list[str]:
    """Return the names between the commas of a text."""
    rows = csv.reader([names.replace("\n", ",")], skipinitialspace=True)
    return [name.strip() for row in rows for name in row if name.strip()]


def _number(name: str) -> int | None:
    """Return the id that ``name`` writes out; None for other names."""
    if not re.fullmatch(r"[0-9]{1,10}|0[xX][0-9a-fA-F]{1,8}", name):
        return None
    number = int(name, 16 if name[:2] in ("0x", "0X") else 10)
    return number if number < _IDS else None


def _fitting(pattern: str, known: Mapping[str, int]) -> Iterable[int]:
    """Return the ids of all names that a name with wildcards stands for; ArgumentError where there is none."""
    if not known:
        raise ArgumentError(
            f"{pattern!r} has a wildcard, but the ids come without a manifest that names them",
            hint="names that are written out are found without one",
            parameter="names",
        )
    expression = re.escape(pattern).replace(r"\*", ".*").replace(r"\?", ".")
    found = [known[name] for name in known if re.fullmatch(expression, name, re.DOTALL)]
    if not found:
        raise _unknown(f"no object is called like {pattern!r}", pattern, known)
    return found


def _unknown(message: str, name: str, known: Mapping[str, int]) -> ArgumentError:
    """Return the error for a name that is not in the manifest: with the nearest one, and what there is."""
    shown = ", ".join(sorted(known)[:12]) + (f" and {len(known) - 12} more" if len(known) > 12 else "")
    near = nearest(name, known)
    hint = f"known: {shown}" if near.startswith("known") else f"{near} known: {shown}"
    return ArgumentError(message, code="unknown-name", hint=hint, parameter="names")


# ---------------------------------------------------------------------- the hash


def cryptomatte_id(name: str) -> int:
    """Return the id that a Cryptomatte has for a name: its hash, as the bits of a float that is a normal number."""
    number = murmur3(name.encode("utf-8"))
    exponent = number >> 23 & 0xFF
    return number ^ 1 << 23 if exponent in (0, 0xFF) else number


def murmur3(data: bytes, seed: int = 0) -> int:
    """Return MurmurHash3_x86_32 of some bytes: A. Appleby, 2011, public domain."""
    h, whole = seed, len(data) // 4 * 4
    for i in range(0, whole, 4):
        h ^= _scrambled(int.from_bytes(data[i : i + 4], "little"))
        h = (_rotated(h, 13) * 5 + 0xE6546B64) % _IDS
    h ^= _scrambled(int.from_bytes(data[whole:], "little")) ^ len(data)
    h = (h ^ h >> 16) * 0x85EBCA6B % _IDS
    h = (h ^ h >> 13) * 0xC2B2AE35 % _IDS
    return h ^ h >> 16


def _scrambled(k: int) -> int:
    """Return four bytes as the hash takes them in; 0 stays 0."""
    return _rotated(k * 0xCC9E2D51 % _IDS, 15) * 0x1B873593 % _IDS


def _rotated(x: int, bits: int) -> int:
    """Return 32 bits turned to the left."""
    return (x << bits | x >> 32 - bits) % _IDS
