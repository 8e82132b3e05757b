"""Tell the encoding of a DPX from its own field, the transfer characteristic (SMPTE 268M)."""

from __future__ import annotations

from typing import TYPE_CHECKING

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


def declares(spec: oiio.ImageSpec) -> bool:
    """Return whether a header is that of a DPX, which has the field even where it says nothing."""
    return spec.getattribute("dpx:Transfer") is not None


def declared(spec: oiio.ImageSpec) -> tuple[str, str]:
    """Return the name of the encoding that the transfer characteristic says, and where it was found, for the log.

    Without a characteristic it is what a comp package takes such a file for.

    OpenImageIO's own tag is not asked: it passes printing density over, and differs from version to version.
    """
    transfer = spec.get_string_attribute("dpx:Transfer")
    bits = spec.get_int_attribute("oiio:BitsPerSample", 8 * spec.format.size())
    if transfer == "ADX" and bits in (10, 16):
        return f"ADX{bits}", f"transfer characteristic {transfer}"
    if transfer in _TRANSFERS:
        return _TRANSFERS[transfer], f"transfer characteristic {transfer}"
    usual = {8: "srgb_rec709_scene", 32: "lin_rec709", 64: "lin_rec709"}.get(bits, "cineon")
    return usual, f"no transfer characteristic in the file, {bits} bits are taken as"
