"""DPX (SMPTE 268M): scanned or recorded film, mostly the log of printing density in 10 bits. Read only."""

from __future__ import annotations

import math
import os
import struct
from typing import TYPE_CHECKING

from flowabs_nodes.color.dpx import declared
from flowabs_nodes.errors import ReadError
from flowabs_nodes.io.formats.declare import Declared, Format

if TYPE_CHECKING:
    import OpenImageIO as oiio


def _declared(spec: oiio.ImageSpec) -> Declared:
    """Return what the transfer characteristic says."""
    return Declared(*declared(spec))


#: Components of a pixel, by the header's descriptor: luma and single channels, RGB, and Y'CbCr 4:2:2 to 4:4:4:4.
_COMPONENTS = {1: 1, 2: 1, 3: 1, 4: 1, 6: 1, 8: 1, 50: 3, 51: 4, 52: 4, 100: 2, 101: 3, 102: 3, 103: 4}
_UNDEFINED = 0xFFFFFFFF


def _check(path: str) -> None:
    """Raise ReadError for a file that OpenImageIO reads as if all were well, though it is not.

    OpenImageIO 3.0 reads missing lines of 10 and 12 bits as black. Up to 3.2 at least, it leaves the last component of
    a line undefined where pixels of four components of 10 bits, three in a word, leave one for the last word.
    """
    with open(path, "rb") as file:
        header = file.read(2048).ljust(2048, b"\0")
    order = ">" if header.startswith(b"SDPX") else "<"
    elements, width, height = struct.unpack_from(order + "HII", header, 770)
    (data,) = struct.unpack_from(order + "I", header, 4)
    size = os.path.getsize(path)
    for element in range(min(elements, 8)):
        descriptor, bits, packing, encoding, offset = struct.unpack_from(order + "BxxBHHI", header, 800 + 72 * element)
        filled, each = packing != 0, _COMPONENTS.get(descriptor, 0)
        if bits == 10 and filled and each == 4 and width * each % 3 == 1:
            raise ReadError(
                f"four components of 10 bits in lines of {width} pixels are not decoded right by OpenImageIO",
                hint="write it with 16 bits, or without alpha",
                file=path,
            )
        if encoding == 0:  # else run lengths: any size may be right
            line = _bytes_of_line(width * each, bits, filled)
            missing = (data if offset in (0, _UNDEFINED) else offset) + line * height - size
            if missing > 0:
                text = f"damaged or cut short: {missing} bytes are missing at its end"
                raise ReadError(text, code="damaged", file=path)


def _bytes_of_line(components: int, bits: int, filled: bool) -> int:
    """Return how many bytes a line of so many components takes at least."""
    if bits == 10 and filled:  # three in a word of 32 bits
        return 4 * math.ceil(components / 3)
    if bits == 12 and filled:  # one in 16 bits
        return 2 * components
    if bits in (10, 12):  # without gaps, up to a whole word
        return 4 * math.ceil(components * bits / 32)
    return components * bits // 8


DPX = Format(
    name="DPX",
    oiio_name="dpx",
    extensions=(".dpx",),
    magic=(b"SDPX", b"XPDS"),  # big and little endian
    help=(
        "A DPX is what its transfer characteristic says: printing density and logarithmic are Kodak's Cineon, video "
        "counts as sRGB. Without one, 10, 12 and 16 bits count as Cineon, 8 bits as sRGB. A camera's log has to be "
        'named: `colorspace` "arri_logc3_ei800", "slog3_sgamut3", "ADX10" ... Every log becomes scene-linear.'
    ),
    declared=_declared,
    check=_check,
    storage=(
        "dpx:BlackGain",
        "dpx:BlackLevel",
        "dpx:BreakPoint",
        "dpx:Colorimetric",
        "dpx:DittoKey",
        "dpx:EncryptKey",
        "dpx:EndOf",
        "dpx:Gamma",
        "dpx:High",
        "dpx:ImageDescriptor",
        "dpx:Low",
        "dpx:Packing",
        "dpx:Signal",
        "dpx:Transfer",
        "dpx:UserData",
        "dpx:Version",
        "dpx:WhiteLevel",
    ),
)
