"""PNG: sRGB unless it says otherwise, straight alpha, 8 or 16 bits."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, BinaryIO

from flowabs_nodes.io.formats.declare import Format

if TYPE_CHECKING:
    import OpenImageIO as oiio

#: The header's chunks that are read here, and the most bytes of one.
_CHUNKS = (b"cICP", b"iCCP", b"sRGB", b"gAMA", b"cHRM")
_LONGEST = 64
#: What cHRM holds, as a PNG that is sRGB says it: white, red, green, blue.
_REC709 = (31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000)


def _complete(path: str, spec: oiio.ImageSpec) -> None:
    """Add the primaries and code points, which OpenImageIO (cHRM, and before 3.1 cICP) leaves out.

    Where a PNG says its colours several times, cICP counts, then iCCP, sRGB, and gAMA with cHRM last.
    """
    with open(path, "rb") as file:
        found = _header_chunks(file)
    if len(found.get(b"cICP", b"")) == 4:
        spec.attribute("CICP", "int[4]", tuple(found[b"cICP"]))
    elif b"iCCP" not in found and b"sRGB" not in found and len(found.get(b"cHRM", b"")) == 32:
        white_first = struct.unpack(">8I", found[b"cHRM"])
        if max(abs(a - b) for a, b in zip(white_first, _REC709, strict=True)) > 100:
            spec.attribute("chromaticities", "float[8]", tuple(x / 1e5 for x in white_first[2:] + white_first[:2]))
            spec.erase_attribute("oiio:ColorSpace")  # it knows the gamma alone
            gamma = found.get(b"gAMA", b"")
            if len(gamma) == 4 and any(gamma):
                spec.attribute("oiio:Gamma", 1e5 / struct.unpack(">I", gamma)[0])


def _header_chunks(file: BinaryIO) -> dict[bytes, bytes]:
    """Return the first bytes of the chunks on colour, by their names; those behind the pixels do not count."""
    found: dict[bytes, bytes] = {}
    file.seek(8)
    while len(head := file.read(8)) == 8:
        size, name = struct.unpack(">I4s", head)
        if name in (b"IDAT", b"IEND"):
            break
        data = file.read(min(size, _LONGEST)) if name in _CHUNKS else b""
        if name in _CHUNKS:
            found.setdefault(name, data)
        file.seek(size - len(data) + 4, 1)
    return found


PNG = Format(
    name="PNG",
    oiio_name="png",
    extensions=(".png",),
    magic=(b"\x89PNG",),
    display_referred=True,
    alpha="straight",
    complete=_complete,
    encoder="flowabs_nodes.io.encode_flat:encode_flat",
    data_types=("uint8", "uint16"),
    storage=("png:",),
)
