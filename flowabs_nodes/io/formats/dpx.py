"""DPX (SMPTE 268M): scanned or recorded film, mostly the log of printing density in 10 bits. Read only."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flowabs_nodes.io.formats.declare import Declared, Format

if TYPE_CHECKING:
    import OpenImageIO as oiio

#: What a transfer characteristic means, in OpenImageIO's words: a colour space by name.
_TRANSFERS = {
    "Printing density": "cineon",
    "Logarithmic": "cineon",
    "Linear": "lin_rec709",
    "Unspecified video": "srgb_rec709_scene",
    "SMPTE 274M": "srgb_rec709_scene",
    "ITU-R 709-4": "srgb_rec709_scene",
    "ITU-R 601-5 system B or G": "srgb_rec709_scene",
    "ITU-R 601-5 system M": "srgb_rec709_scene",
    "NTSC composite video": "srgb_rec709_scene",
    "PAL composite video": "srgb_rec709_scene",
    "Z depth linear": "data",
    "Z depth homogeneous": "data",
}


def _declared(spec: oiio.ImageSpec) -> Declared:
    """Return what the transfer characteristic says; without one, what a comp package takes such a file for.

    OpenImageIO's own tag is not asked: it passes printing density over, and differs from version to version.
    """
    transfer = spec.get_string_attribute("dpx:Transfer")
    bits = spec.get_int_attribute("oiio:BitsPerSample", 8 * spec.format.size())
    if transfer == "ADX" and bits in (10, 16):
        return Declared(f"ADX{bits}", f"transfer characteristic {transfer}")
    if transfer in _TRANSFERS:
        return Declared(_TRANSFERS[transfer], f"transfer characteristic {transfer}")
    usual = {8: "srgb_rec709_scene", 32: "lin_rec709", 64: "lin_rec709"}.get(bits, "cineon")
    return Declared(usual, f"no transfer characteristic in the file, {bits} bits are taken as")


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
