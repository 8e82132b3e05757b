"""Translate metadata between OpenImageIO's names and types and those of an EXR header.

An attribute's name and type differ between the two: OpenImageIO's "DateTime" is EXR's "capDate".
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import OpenEXR
import OpenImageIO as oiio

from flowabs_nodes.errors import WriteError
from flowabs_nodes.io import formats
from flowabs_nodes.io.standard_attributes import standard_value

#: The name in an EXR header -> OpenImageIO's name, where they differ.
OIIO_NAMES = {
    "owner": "Copyright",
    "capDate": "DateTime",
    "comments": "ImageDescription",
    "expTime": "ExposureTime",
    "aperture": "FNumber",
    "xDensity": "XResolution",
    "timeCode": "smpte:TimeCode",
    "keyCode": "smpte:KeyCode",
    "pixelAspectRatio": "PixelAspectRatio",
}
EXR_NAMES = {theirs: name for name, theirs in OIIO_NAMES.items()} | {
    "oiio:ColorSpace": "colorInteropID",
    "FramesPerSecond": "framesPerSecond",
    "worldtocamera": "worldToCamera",
    "worldtoscreen": "worldToScreen",
    "oiio:subimagename": "name",
}

#: Attributes, by name or beginning, that describe how pixels were stored in some file, not the picture: never carried
#: from one file to another. Each format adds its own.
_STORAGE = (
    *(name for format in formats.ALL for name in format.storage),
    "oiio:",
    "ICCProfile",
    "thumbnail_",
    "compression",
    "planarconfig",
    "textureformat",
    "flowabs:",
    "Exif:ColorSpace",
    "Exif:PixelXDimension",
    "Exif:PixelYDimension",
    "CICP",
    "colorInteropID",
)

#: EXR attributes that describe the file's structure: with a wrong value the file cannot be read.
_STRUCTURE = (
    "channels",
    "chromaticities",
    "chunkCount",
    "dataWindow",
    "displayWindow",
    "dwaCompressionLevel",
    "lineOrder",
    "multiView",
    "name",
    "pixelAspectRatio",
    "preview",
    "screenWindowCenter",
    "screenWindowWidth",
    "tiles",
    "type",
    "view",
    "zipCompressionLevel",
)

_MATRICES = {9: (3, 3), 16: (4, 4)}


def values(spec: oiio.ImageSpec) -> dict[str, tuple[str, Any]]:
    """Return every attribute of a spec, name -> (type, value); arrays become tuples, which compare by value."""
    found = {}
    for attribute in spec.extra_attribs:
        try:
            value = attribute.value
        except UnicodeDecodeError:  # OpenImageIO 3.0, where a text is no UTF-8
            continue
        if isinstance(value, np.ndarray):
            value = tuple(value.ravel().tolist())
        found[attribute.name] = (str(attribute.type), value)
    return found


def describes_picture(name: str) -> bool:
    """Return False for an attribute that only says how a file stored its pixels."""
    return not name.startswith(_STORAGE)


def settable(name: str) -> bool:
    """Return True for a name that ``write.metadata`` may set: none about how pixels are stored or where they lie."""
    fits = 0 < len(name.encode("utf-8", "replace")) <= 255 and "\0" not in name
    return fits and EXR_NAMES.get(name, name) not in _STRUCTURE and describes_picture(name)


def given(name: str, value: str | float) -> tuple[str, Any]:
    """Return the (name, value) that the OpenEXR module writes for an attribute that ``write.metadata`` sets.

    A standard attribute has the standard's type, any other that of the value. Raises WriteError where the value cannot
    be of the type.
    """
    exr_name = EXR_NAMES.get(name, name)
    try:
        content = standard_value(exr_name, value)
    except ValueError as error:
        message = f"metadata {name!r}: expected {error}, found {value!r}"
        raise WriteError(message, code="bad-value", parameter="metadata") from None
    translated = to_exr(name, "", content) if content is value else (exr_name, content)
    if translated is None:
        raise WriteError(f"metadata {name!r}: an EXR attribute's name has at most 255 bytes", parameter="metadata")
    return translated


def to_exr(name: str, kind: str, value: Any) -> tuple[str, Any] | None:
    """Return the (name, value) that the OpenEXR module writes for an attribute; None where EXR has no such type.

    ``kind`` is OpenImageIO's type, such as "float[8]"; "" leaves the type to the value.
    """
    name = EXR_NAMES.get(name, name)
    try:
        if len(name.encode("utf-8")) > 255:
            return None
    except UnicodeEncodeError:  # OpenImageIO has surrogates in a name that is no UTF-8
        return None
    base = kind.split("[")[0]
    if isinstance(value, str):
        return name, value.encode("utf-8", "replace").decode("utf-8")
    if isinstance(value, int) and base not in ("double", "float", "half"):
        return (name, value) if -(2**31) <= value < 2**31 else (name, str(value))
    if isinstance(value, int | float):
        return name, float(value)
    if not isinstance(value, tuple | list) or not value:
        return None
    if all(isinstance(item, str) for item in value):
        return name, [item.encode("utf-8", "replace").decode("utf-8") for item in value]
    if "rational" in base and len(value) == 2 and value[1]:
        return name, Fraction(int(value[0]), int(value[1]))
    if base == "timecode":
        return name, _timecode(int(value[0]), int(value[1]))
    if base == "keycode":
        return name, OpenEXR.KeyCode(*(int(part) for part in value))
    if name == "chromaticities" and len(value) == 8:
        return name, tuple(float(item) for item in value)
    if all(isinstance(item, int) for item in value):
        if len(value) == 4 and base in ("box2i", "vector2i"):
            return name, (np.array(value[:2], np.int32), np.array(value[2:], np.int32))
        if len(value) in (2, 3):
            return name, np.array(value, np.int32)
    if kind in ("box2", "float2[2]") and len(value) == 4:
        return name, (np.array(value[:2], np.float32), np.array(value[2:], np.float32))
    numbers = np.array(value, np.float64 if base == "double" and len(value) in (2, 3, 9, 16) else np.float32)
    if base in ("matrix", "matrix33", "double") and len(value) in _MATRICES:
        return name, numbers.reshape(_MATRICES[len(value)])
    return name, numbers if len(value) in (2, 3) else [float(item) for item in numbers]


def to_spec(header: dict[str, Any], spec: oiio.ImageSpec) -> None:
    """Put an EXR header's attributes on a spec, under OpenImageIO's names; types that OpenImageIO lacks are dropped."""
    for name, value in header.items():
        theirs = OIIO_NAMES.get(name, name)
        if isinstance(value, str | float) or (isinstance(value, int) and not hasattr(value, "name")):
            spec.attribute(theirs, value)
        elif isinstance(value, Fraction):
            spec.attribute(theirs, oiio.TypeRational, (value.numerator, value.denominator))
        elif isinstance(value, tuple) and len(value) == 8:
            spec.attribute(theirs, oiio.TypeDesc("float[8]"), value)
        elif isinstance(value, np.ndarray) and value.dtype == np.float32 and value.size in (2, 3, 16):
            kind = {2: oiio.TypeFloat2, 3: oiio.TypeVector, 16: oiio.TypeMatrix}[value.size]
            spec.attribute(theirs, kind, tuple(value.ravel().tolist()))


def _timecode(time: int, user: int) -> OpenEXR.TimeCode:
    """Unpack SMPTE 12M time and user data, packed for 60-field television as OpenImageIO holds them."""

    def digits(shift: int, bits: int) -> int:
        """Return the number of two binary-coded decimal digits."""
        packed = time >> shift & (1 << bits) - 1
        return (packed >> 4) * 10 + (packed & 15)

    def flag(bit: int) -> int:
        return time >> bit & 1

    clock = digits(24, 6), digits(16, 7), digits(8, 7), digits(0, 6)
    flags = flag(6), flag(7), flag(15), flag(23), flag(30), flag(31)
    return OpenEXR.TimeCode(*clock, *flags, *(user >> 4 * group & 15 for group in range(8)))
