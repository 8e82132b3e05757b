"""Encode a picture as the bytes of an EXR file, in memory, with the OpenEXR module.

OpenImageIO's writer is not used: on a full disk it can report success over a file cut short.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import OpenEXR
import OpenImageIO as oiio

from flowabs_nodes import color, encodings
from flowabs_nodes.array_types import Array
from flowabs_nodes.color import ocio
from flowabs_nodes.color.display import to_display
from flowabs_nodes.errors import WriteError
from flowabs_nodes.image import Image
from flowabs_nodes.io import alpha as alphas
from flowabs_nodes.io import attributes, exr_header, nonfinite, pixel_hash
from flowabs_nodes.io.exr_threads import encoding_threads
from flowabs_nodes.io.formats import Format
from flowabs_nodes.io.output_image import Picture, layer_planes, main_planes
from flowabs_nodes.io.passthrough import alpha_left_out, passthrough_layers
from flowabs_nodes.io.provenance import KEY, PIXELS
from flowabs_nodes.port_types import pixel_type
from flowabs_nodes.simd.bands import over_rows

Say = Callable[[str], None]
Planes = dict[str, npt.NDArray[Any]]

HALF_MAX = 65504.0

#: Attributes that all parts of a file must agree on.
_SHARED = ("displayWindow", "pixelAspectRatio", "timeCode", "chromaticities")
_TYPES = {"float16": "half", "float32": "float", "uint32": "uint"}


def encode_exr(picture: Picture, format: Format, stamps: Mapping[str, str], warn: Say) -> bytes:
    """Return the file's bytes: the main part with image, layers and kept layers, then the kept parts.

    ``stamps`` are attributes of the main part, and with a key a hash of the pixels joins them. ``warn`` is told what
    had to be changed (NaN, values beyond half), and of a lossy compression. Raises WriteError where two channels would
    have one name, or the OpenEXR module refuses a header.
    """
    channels = _channels("", picture.image, picture, format, warn)
    own = channels.keys()
    for name, layer in picture.layers.items():
        of_layer = _channels(name, layer, picture, format, warn)
        if twice := sorted(own & of_layer.keys()):
            raise WriteError(
                f"channel {twice[0]} would be both the image's and a layer's", hint="give the input another name"
            )
        channels = {**channels, **of_layer}
    channels.update(alpha_left_out(picture, warn))
    kept = passthrough_layers(picture, warn)
    channels = {**kept.channels, **channels}

    header = exr_header.exr_header(picture.image, picture.settings, warn)
    header.update(_color_tags(picture, format, header, warn))
    if picture.shown_by is not None and picture.image.type == "color":
        warn(f"holds the codes of a display ({picture.shown_by}), which others take for scene-linear light")
    for name, value in picture.metadata.items():
        translated, content = attributes.given(name, value)
        header[translated] = content
    header.update(stamps)
    if KEY in stamps:
        header[PIXELS] = pixel_hash.PLACE
    plate = exr_header.plate_compression(picture.image.spec)
    exr_header.set_views(header, picture.image, channels, picture.settings)
    parts = [_part(header, channels, picture.compression, plate if picture.plate_format is format else "", warn)]
    for other, planes in kept.parts:
        theirs = other.pop("compression", "")
        other = {**other, **{name: header[name] for name in _SHARED if name in header}}
        other = {name: value for name, value in other.items() if name in header or name not in _SHARED}
        parts.append(_part(other, planes, "auto", theirs, warn))
    if len(parts) > 1:
        _name(parts)
    exr_header.check_container(parts)
    stream = io.BytesIO()
    try:
        with encoding_threads():
            OpenEXR.File([OpenEXR.Part(part, planes, part.get("name", "")) for part, planes in parts]).write(stream)
    except (RuntimeError, ValueError, TypeError) as error:
        raise WriteError(f"cannot be encoded as EXR: {error}") from error
    if KEY in stamps:
        pixel_hash.sign_exr(stream, PIXELS)
    return stream.getvalue()


def _channels(name: str, image: Image, picture: Picture, format: Format, warn: Say) -> Planes:
    """Return the channels of a layer, or of the main image, "", in their final type.

    The image's decoded pixels are let go of: of one picture after the other there are only those in their final type.
    """
    pixels = _pixels(picture, image)
    planes = layer_planes(name, image, pixels) if name else main_planes(image, pixels)
    typed = _typed(name or "image", image, planes, _data_type(picture, image, format, warn), warn)
    encodings.current().let_go(image)
    return typed


def _pixels(picture: Picture, image: Image) -> Array:
    """Return an image's pixels in the space that the file is to have; only a color image is ever converted."""
    shown_by = picture.shown_by
    if image.type != "color" or (picture.colorspace == "plate" and shown_by is None):
        return image.pixels
    rgb, coverage = image.pixels[..., :3], image.alpha
    straight = rgb if coverage is None else alphas.straight(rgb, coverage)
    if shown_by is not None:
        encoded = to_display(straight, image.colorspace, shown_by, picture.settings.ocio)
    else:
        encoded = ocio.encode_named(straight, image.colorspace, picture.colorspace, picture.settings.ocio)
    if coverage is not None:
        encoded = alphas.premultiplied(encoded, coverage)
        hollow = coverage <= 0
        encoded[hollow] = rgb[hollow]
    return np.concatenate([encoded, image.pixels[..., 3:]], axis=2)


def _color_tags(picture: Picture, format: Format, header: dict[str, Any], warn: Say) -> dict[str, Any]:
    """Return the attributes that name the file's colours; none where the plate's own, in ``header``, are still true.

    Those of the plate that are no longer true are taken out of ``header``.
    """
    image, settings = picture.image, picture.settings
    if picture.shown_by is not None and image.type == "color":
        tags = {"colorInteropID": picture.shown_by.interop_id or "unknown"}
    elif picture.colorspace == "plate":
        if image.type != "color":
            return {}
        said = color.detect(image.spec, ocio=settings.ocio)
        if picture.plate_format is format and said.encoding is None and said.space == image.colorspace:
            return {}
        tags = exr_header.color_tags(image.colorspace, settings.ocio)
    else:
        tags = exr_header.named_color_tags(picture.colorspace, settings.ocio, warn)
    for name in ("chromaticities", "colorInteropID"):
        header.pop(name, None)
    return tags


def _data_type(picture: Picture, image: Image, format: Format, warn: Say) -> str:
    """Choose "half", "float" or "uint" for the channels of an image."""
    stored = pixel_type(image.type).stored
    if stored == "exact":
        return _TYPES[str(image.pixels.dtype)]
    if picture.data_type in format.data_types:
        return picture.data_type
    if picture.data_type != "auto" and image is picture.image:
        warn(f"{format.name} cannot hold {picture.data_type}: data_type auto is used")
    if stored == "float":
        return "float"
    basetype = image.spec.format.basetype
    if stored == "read":
        return "half" if basetype == oiio.HALF else "float"
    return "float" if basetype in (oiio.FLOAT, oiio.DOUBLE) and image.origin is not None else "half"


def _typed(name: str, image: Image, planes: Mapping[str, Array], kind: str, warn: Say) -> Planes:
    """Return planes in their final type, depth, ids and the like as they are, bit for bit.

    ``warn`` is told of every NaN, and of every value beyond the type's range.
    """
    stored = pixel_type(image.type).stored
    nans, infs = nonfinite.count(image.pixels)
    as_they_are = stored in ("read", "exact")
    if as_they_are and (nans or infs):
        warn(f"{name}: {nonfinite.said(nans, infs)} written as they are")
    elif nans:
        warn(f"{name}: {nans} NaN written as 0")
    if stored == "exact":
        return {channel: np.ascontiguousarray(plane) for channel, plane in planes.items()}
    limit = np.float32(HALF_MAX if kind == "half" else np.finfo(np.float32).max)
    clamped = 0
    data_type = np.dtype(np.float16 if kind == "half" else np.float32)
    typed: Planes = {}
    for channel, plane in planes.items():
        if (within := _within(plane, limit, data_type)) is not None:
            typed[channel] = within
            continue
        if nans and not as_they_are:
            plane = np.where(np.isnan(plane), np.float32(0), plane)
        beyond = np.abs(plane) > limit
        if as_they_are:
            beyond &= np.isfinite(plane)
        clamped += int(beyond.sum())
        plane = np.where(beyond, np.copysign(limit, plane), plane)
        typed[channel] = np.ascontiguousarray(plane, data_type)
    if clamped:
        warn(f"{name}: {clamped} values beyond {kind} clamped to ±{limit:.6g}")
    return typed


def _within(plane: npt.NDArray[Any], limit: np.float32, data_type: np.dtype[Any]) -> npt.NDArray[Any] | None:
    """Return a plane (H, W) in a data type, contiguous; None where a number is NaN or further than ``limit`` from 0."""
    as_it_is = plane.dtype == data_type and plane.flags.c_contiguous
    typed = plane if as_it_is else np.empty(plane.shape, data_type)

    def convert(first: int, last: int) -> bool:
        """Convert some rows, which are looked at while they are in the processor's cache."""
        rows = plane[first:last]
        fits = bool(rows.max() <= limit and rows.min() >= -limit)
        if fits and not as_it_is:
            typed[first:last] = rows
        return fits

    return typed if all(over_rows(convert, len(plane))) else None


def _part(header: dict[str, Any], planes: Planes, wanted: str, plate: str, warn: Say) -> tuple[dict[str, Any], Planes]:
    """Return header and channels of a part, with its compression.

    ``wanted`` is the parameter's; "auto" keeps the plate's, ``plate``, if it is lossless for these channels, else zip.
    """
    types = {_TYPES[str(plane.dtype)] for plane in planes.values()}
    chosen = wanted
    if wanted == "auto":
        chosen = plate if plate and exr_header.lossless(plate, types) else "zip"
    elif not exr_header.lossless(wanted, types):
        warn(f"compression {wanted} changes the picture each time it is saved, data layers too")
    constant = exr_header.compression_of(chosen)
    if constant is None:  # the plate's is newer than this OpenEXR
        constant = OpenEXR.ZIP_COMPRESSION
    return {**header, "type": OpenEXR.scanlineimage, "compression": constant}, planes


def _name(parts: list[tuple[dict[str, Any], Planes]]) -> None:
    """Give every part a name of its own, which a file of several parts needs."""
    used: set[str] = set()
    for index, (header, _) in enumerate(parts):
        name = str(header.get("name") or ("rgba" if index == 0 else f"part{index}"))
        while name in used:
            name += "_"
        used.add(name)
        header["name"] = name
