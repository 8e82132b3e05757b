"""Make the header of an EXR: the plate's own, word for word, with what nodes changed on the way."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
import OpenEXR
import OpenImageIO as oiio

from flowabs_nodes import color
from flowabs_nodes.color import ColorSpace, named
from flowabs_nodes.color.chromaticities import chromaticities_by_matrix
from flowabs_nodes.color.config import opened
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image import Image, Window
from flowabs_nodes.io import attributes, formats
from flowabs_nodes.io.color_tags import misread
from flowabs_nodes.io.exr_attributes import stored_header
from flowabs_nodes.io.formats.exr import EXR
from flowabs_nodes.io.image_file import open_picture
from flowabs_nodes.io.layers import few
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.io.views import read_view, views_of, views_there

#: Attributes that the encoder decides, or that are no longer true of new pixels (the thumbnail).
_ENCODING = (
    "channels",
    "chunkCount",
    "compression",
    "dataWindow",
    "displayWindow",
    "dwaCompressionLevel",
    "lineOrder",
    "maxSamplesPerPixel",
    "preview",
    "tiles",
    "type",
    "version",
    "zipCompressionLevel",
)
#: Attributes of a photograph that say how large to print it.
_PRINT = ("XResolution", "YResolution", "ResolutionUnit")


def exr_header(image: Image, settings: Settings, warn: Callable[[str], None]) -> dict[str, Any]:
    """Return attributes for the OpenEXR module: an image's metadata and windows, without what describes the encoding.

    A plate that was an EXR hands its header on as it is, types included; an attribute that a node changed, added or
    removed is changed, added or removed there. Any other image's attributes are translated. ``warn`` is told where the
    plate's header cannot be read any more.
    """
    ours = attributes.values(image.spec)
    theirs, header = _plate(image, settings, warn)
    for name in theirs.keys() - ours.keys():
        header.pop(attributes.EXR_NAMES.get(name, name), None)
    for name, (kind, value) in ours.items():
        if theirs.get(name) != (kind, value) and attributes.describes_picture(name) and name not in _PRINT:
            translated = attributes.to_exr(name, kind, value)
            if translated is not None:
                header[translated[0]] = translated[1]
    header = {
        name: value for name, value in header.items() if name not in _ENCODING and not name.startswith("flowabs:")
    }
    header["dataWindow"] = _box(image.data_window)
    header["displayWindow"] = _box(image.display_window)
    return header


def header_of_part(path: str, part: int, warn: Callable[[str], None]) -> dict[str, Any]:
    """Return a part's own header, without what describes the encoding. ``warn`` is told what cannot be written again.

    Raises ReadError where the file has no such part.
    """
    header, left_out = stored_header(path, part)
    if left_out:
        warn(f"attributes of the plate that cannot be written again are left out: {few(left_out)}")
    windows = {name: header[name] for name in ("dataWindow", "displayWindow")}
    return {
        name: value for name, value in header.items() if name not in _ENCODING and not name.startswith("flowabs:")
    } | windows


def set_views(header: dict[str, Any], image: Image, channels: Iterable[str], settings: Settings) -> None:
    """Make multiView in ``header`` name the views that are among ``channels``; the one that was read is the default.

    Where one view is left, the attribute ``view`` names it, and multiView goes. Where all views that the plate has are
    there, the header stays as it is.
    """
    views, origin = views_of(image.spec), image.origin
    if not views or origin is None or "multiView" not in header:
        return
    try:
        with open_picture(origin.file, settings) as file:
            before = views_there(file.specs[origin.part].channelnames, views, views[0])
    except (FlowabsError, IndexError):  # the plate is gone: what is written is all that is known
        before = ()
    there = views_there(channels, views, read_view(origin, views))
    if there == before:
        return
    if len(there) > 1:
        header["multiView"] = list(there)
    else:
        del header["multiView"]
        header["view"] = there[0]


def check_container(parts: Sequence[tuple[dict[str, Any], dict[str, Any]]]) -> None:
    """Remove acesImageContainerFlag where the file is no ACES image container (SMPTE ST 2065-4).

    One is a single part of half R, G, B[, A] in ACES2065-1, without compression.
    """
    header, channels = parts[0]
    tagged = header.get("chromaticities")
    ap0 = color.chromaticities_of(color.space("lin_ap0_scene")) or ()
    true = (
        len(parts) == 1
        and header.get("compression") == OpenEXR.NO_COMPRESSION
        and set(channels) in ({"R", "G", "B"}, {"R", "G", "B", "A"})
        and all(plane.dtype == np.float16 for plane in channels.values())
        and tagged is not None
        and np.allclose(tagged, ap0, atol=1e-4)
    )
    for each, _ in parts:
        if not true:
            each.pop("acesImageContainerFlag", None)


def _plate(image: Image, settings: Settings, warn: Callable[[str], None]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Read an EXR plate's attributes as OpenImageIO gives them, and its header as the OpenEXR module does.

    Both are empty where the image does not come from an EXR, or that file cannot be read any more.
    """
    origin = image.origin
    if origin is None or formats.by_extension(origin.file) is not EXR:
        return {}, {}
    try:
        with open_picture(origin.file, settings) as file:
            theirs = attributes.values(file.specs[origin.part])
            return theirs, header_of_part(file.place, origin.part, warn)
    except (FlowabsError, IndexError) as error:
        warn(f"the plate's header cannot be copied word for word ({error}): its known attributes are written")
        return {}, {}


def _box(window: Window) -> tuple[Any, Any]:
    """Return a window as EXR's box2i: first and last pixel."""
    low = np.array([window.x, window.y], np.int32)
    return low, np.array([window.x + window.width - 1, window.y + window.height - 1], np.int32)


def color_tags(space: ColorSpace, ocio: str | None = None) -> dict[str, Any]:
    """Return a linear space's ``colorInteropID``, and its chromaticities for readers that do not know that name.

    The name is left out where it is one of the config's that means another space to readers without the config.
    """
    tags: dict[str, Any] = {}
    known = space.interop_id
    if known or not (space.name.startswith("chromaticities(") or misread(space.name, opened(ocio))):
        tags["colorInteropID"] = known or space.name
    chromaticities = color.chromaticities_of(space)
    if chromaticities is None and opened(ocio).content:
        chromaticities = chromaticities_by_matrix(space)  # nobody else knows the config
    return tags | ({"chromaticities": chromaticities} if chromaticities else {})


def named_color_tags(name: str, ocio: str | None, warn: Callable[[str], None]) -> dict[str, Any]:
    """Return the same for any OCIO name: an alias of a linear space, or an encoding. Raises ColorError for others.

    ``warn`` is told of a name that means something else to readers without the config: such colours are "unknown".
    """
    found = named.find(name, ocio)
    if found.kind == "linear":
        return color_tags(found.space, ocio)
    if misread(name, opened(ocio)):
        warn(f"its colours are tagged as unknown: {name!r} is another space to readers without this OCIO config")
        return {"colorInteropID": "unknown"}
    known = OpenEXR.colorInteropIDToChromaticities(name)
    return {"colorInteropID": name} | ({"chromaticities": known} if known else {})


def lossless(compression: str, types: set[str]) -> bool:
    """Return True if a compression gives back every bit of channels of these types ("half", "float", "uint")."""
    name = compression.split(":")[0].lower()
    if name == "pxr24":
        return "float" not in types
    return name in ("none", "rle", "zips", "zip", "piz", "zstd") or name.startswith("htj2k")


def compression_of(name: str) -> Any:
    """Return the OpenEXR module's constant for a compression such as "dwaa:45"; None where it has none."""
    short = name.split(":")[0].upper()
    return getattr(OpenEXR, "NO_COMPRESSION" if short == "NONE" else f"{short}_COMPRESSION", None)


def plate_compression(spec: oiio.ImageSpec) -> str:
    """Return the compression that a plate came in, such as "zip" or "dwaa:45"; empty where its header names none."""
    return str(spec.get_string_attribute("compression"))
