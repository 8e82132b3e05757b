"""Encode a picture as the bytes of a file made to be looked at (PNG, TIFF): one image, on its display window."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes import color
from flowabs_nodes.color import ocio
from flowabs_nodes.color.config import opened
from flowabs_nodes.color.display import DisplayView, to_display
from flowabs_nodes.color.encoding import Encoding
from flowabs_nodes.errors import ReadError, WriteError
from flowabs_nodes.image import Image
from flowabs_nodes.io import alpha as alphas
from flowabs_nodes.io import attributes, color_tags, nonfinite, provenance
from flowabs_nodes.io.formats import Format
from flowabs_nodes.io.image_file import open_picture
from flowabs_nodes.io.limits import check_display_window
from flowabs_nodes.io.oiio_error import reason
from flowabs_nodes.io.output_image import Picture, main_planes
from flowabs_nodes.io.pixel_hash import decoded_hash
from flowabs_nodes.io.private_folder import is_full, no_space_in, private_folder
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.port_types import pixel_type

Say = Callable[[str], None]

_BASETYPES = {
    oiio.UINT8: "uint8",
    oiio.UINT16: "uint16",
    oiio.HALF: "float",
    oiio.FLOAT: "float",
    oiio.DOUBLE: "float",
}


def encode_flat(picture: Picture, format: Format, stamps: Mapping[str, str], warn: Say) -> bytes:
    """Return the file's bytes: colour encoded for the screen, alpha straight; mattes and mono as they are.

    ``stamps`` are stored where ``format.stamps`` says, and with a key a hash of the pixels; ``warn`` is told what the
    format cannot hold. Raises WriteError for an image that is no picture to look at (flow, depth, ids ...), for a
    display window above ``max_pixels``, and where OpenImageIO fails.
    """
    image = picture.image
    declared = pixel_type(image.type)
    if not declared.shown:
        raise WriteError(f"{format.name} cannot hold {declared.an_image}; write an EXR", code="bad-format")
    if picture.keep_layers:
        warn(f"{format.name} holds one image: the plate's other layers are left out")
    display = image.display_window
    check_display_window(display.width, display.height, picture.settings)
    image = image.on_window(display)
    data_type = _data_type(picture, format, warn)
    encoding = _encoding(picture, format, data_type, warn)
    linear = encoding is None and image.type == "color" and picture.shown_by is None
    if linear and image.colorspace != color.space("lin_rec709"):
        warn(f"{format.name} cannot say that its colours are {image.colorspace}; colorspace converts them")
    pixels = _quantised(_encoded(image, encoding, picture, warn), data_type)
    if provenance.KEY in stamps:
        stamps = {**stamps, provenance.PIXELS: decoded_hash(pixels)}
    return _through_oiio(format, _header(picture, format, data_type, pixels, encoding, stamps), pixels)


def _from_scene(picture: Picture) -> bool:
    """Return True where the plate's file was not made to be looked at, so that its encoding is not the output's."""
    return picture.plate_format is not None and not picture.plate_format.display_referred


def _data_type(picture: Picture, format: Format, warn: Say) -> str:
    """Choose one of ``format.data_types``: the one asked for, the plate's, or the first."""
    if picture.data_type in format.data_types:
        return picture.data_type
    if picture.data_type != "auto":
        warn(f"{format.name} cannot hold {picture.data_type}: data_type auto is used")
    plate = _BASETYPES.get(picture.image.spec.format.basetype, "")
    kept = picture.image.origin is not None and not (plate == "float" and _from_scene(picture))
    return plate if kept and plate in format.data_types else format.data_types[0]


def _encoding(picture: Picture, format: Format, data_type: str, warn: Say) -> str | Encoding | None:
    """Choose the encoding of the file's colours; None where they stay scene-linear, or are no colours at all.

    It is the plate's own where the file can say so, else sRGB.
    """
    if picture.image.type != "color":
        return None
    whole_numbers = data_type != "float"
    if picture.shown_by is not None:
        return _display_encoding(picture.shown_by, format, data_type, picture.settings, warn)
    if picture.colorspace != "plate":
        chosen = color_tags.sayable(format, data_type, picture.colorspace, opened(picture.settings.ocio))
        if chosen is None:
            warn(
                f"{format.name} cannot say that its colours are {picture.colorspace!r}: others will take them for sRGB"
            )
        return chosen or picture.colorspace
    plate = _plate_colors(picture, data_type)
    if plate and plate.encoding:
        chosen = color_tags.sayable(format, data_type, plate.encoding, opened(picture.settings.ocio))
        if chosen is not None:
            return chosen
        written = "sRGB is" if whole_numbers else "scene-linear colours are"
        warn(f"{format.name} cannot say what the plate's colours are: {written} written, not {plate.encoding}")
    return color_tags.SRGB if whole_numbers else None


def _plate_colors(picture: Picture, data_type: str) -> color.Detected | None:
    """Return what the header says of the plate's colours; None where the plate was not made to be looked at."""
    if _from_scene(picture):
        return None
    return color.detect(picture.image.spec, ocio=picture.settings.ocio, display_referred=data_type != "float")


def _display_encoding(
    shown_by: DisplayView, format: Format, data_type: str, settings: Settings, warn: Say
) -> str | Encoding | None:
    """Choose how the file says what the display's codes are; None where they are numbers, or cannot be named."""
    if shown_by.data:
        return None
    known = shown_by.encoding
    chosen = None if known is None else color_tags.sayable(format, data_type, known, opened(settings.ocio))
    if chosen is None:
        warn(f"{format.name} cannot say that its colours are of {shown_by.display!r}: others will take them for sRGB")
    return chosen


def _encoded(image: Image, encoding: str | Encoding | None, picture: Picture, warn: Say) -> npt.NDArray[np.float32]:
    """Return (H, W, 3 or 4): straight colour in its encoding, or its view's; scene-linear, premultiplied without."""
    pixels = image.pixels
    nans, _ = nonfinite.count(pixels)
    if nans:
        warn(f"image: {nans} NaN written as 0")
        pixels = np.nan_to_num(pixels, nan=0.0, posinf=np.inf, neginf=-np.inf)
    planes = main_planes(image, pixels)
    shown_by = picture.shown_by if image.type == "color" else None
    if encoding is None and shown_by is None:
        return np.stack(list(planes.values()), axis=2)
    rgb = pixels[..., :3]
    if "A" in planes:
        rgb = alphas.straight(rgb, planes["A"])
    if shown_by is not None:
        rgb = to_display(rgb, image.colorspace, shown_by, picture.settings.ocio)
    elif encoding is not None:
        rgb = ocio.encode_named(rgb, image.colorspace, encoding, picture.settings.ocio)
    return np.concatenate([rgb, pixels[..., 3:]], axis=2)


def _quantised(pixels: npt.NDArray[np.float32], data_type: str) -> npt.NDArray[np.generic]:
    """Return pixels in the file's data type: 0..1 rounded to whole numbers, or float as they are."""
    if data_type == "float":
        return pixels
    scale = np.float32(255 if data_type == "uint8" else 65535)
    return np.asarray(np.clip(pixels, 0, 1) * scale + np.float32(0.5)).astype(data_type)


def _header(
    picture: Picture,
    format: Format,
    data_type: str,
    pixels: npt.NDArray[np.generic],
    encoding: str | Encoding | None,
    stamps: Mapping[str, str],
) -> oiio.ImageSpec:
    """Return a header with the image's metadata, and the stamps where the format keeps them."""
    height, width, count = pixels.shape
    spec = oiio.ImageSpec(width, height, count, "float" if pixels.dtype == np.float32 else str(pixels.dtype))
    for attribute in picture.image.spec.extra_attribs:
        if attributes.describes_picture(attribute.name) and attribute.name != "chromaticities":
            spec.attribute(attribute.name, attribute.type, attribute.value)
    for name, value in picture.metadata.items():
        spec.attribute(name, value)
    if format.stamps == "description":
        lines = {name: str(value) for name, value in picture.metadata.items() if name != "ImageDescription"}
        text = provenance.in_description(spec.get_string_attribute("ImageDescription"), {**lines, **stamps})
        spec.attribute("ImageDescription", text)
    else:
        for name, stamp in stamps.items():
            spec.attribute(name, stamp)
    if format.compression:
        spec.attribute("compression", format.compression)
    if spec.getattribute("DateTime") is None:
        spec.attribute("DateTime", "")  # else a TIFF gets the time of day, and no two runs write the same bytes
    color_tags.tag(spec, encoding)
    shown_by = picture.shown_by if picture.image.type == "color" else None
    if shown_by is not None and encoding is None:
        spec.attribute("oiio:ColorSpace", "unknown")  # else a PNG would say sRGB
    if _keeps_profile(picture, data_type, encoding):
        color_tags.set_profile(spec, np.asarray(picture.image.spec.getattribute("ICCProfile"), np.uint8).tobytes())
    if encoding is not None or shown_by is not None:
        spec.attribute("oiio:UnassociatedAlpha", 1)
    return spec


def _keeps_profile(picture: Picture, data_type: str, encoding: str | Encoding | None) -> bool:
    """Return whether the plate's ICC profile, which describes the plate's codes, is true of those that are written."""
    profile = picture.image.spec.getattribute("ICCProfile")
    if (
        profile is None
        or isinstance(profile, str | int | float)
        or picture.image.type != "color"
        or picture.colorspace != "plate"
        or picture.shown_by
    ):
        return False
    plate = _plate_colors(picture, data_type)
    if plate is None or plate.encoding != encoding or plate.space != picture.image.colorspace:
        return False
    return np.asarray(profile, np.uint8)[16:20].tobytes() == b"RGB "


def _through_oiio(format: Format, spec: oiio.ImageSpec, pixels: npt.NDArray[np.generic]) -> bytes:
    """Let OpenImageIO, which writes to files only, write a private one; compare its pixels, and return its bytes."""
    with private_folder() as folder:
        path = os.path.join(folder, "picture" + format.extensions[0])
        output = oiio.ImageOutput.create(format.oiio_name)
        if output is None:
            raise WriteError(f"this OpenImageIO does not write {format.name}: {reason(oiio)}")
        wrong = ""
        if not output.open(path, spec):
            wrong = reason(output) or "it cannot be opened"
        elif not output.write_image(pixels):
            wrong = reason(output) or "its pixels cannot be written"
        if not output.close() and not wrong:
            wrong = reason(output) or "it cannot be closed"
        try:
            if not wrong and not _holds(path, pixels):
                wrong = "its pixels are not what was written"
        except ReadError as error:  # it names the private file
            wrong = error.message
        if wrong:
            if is_full(path):
                raise no_space_in(os.path.dirname(folder))
            raise WriteError(f"cannot be encoded as {format.name}: {wrong}")
        with open(path, "rb") as file:
            data = file.read()
        if is_full(path, 1):  # a PNG may lack its last bytes, and its pixels are there all the same
            raise no_space_in(os.path.dirname(folder))
        return data


def _holds(path: str, pixels: npt.NDArray[np.generic]) -> bool:
    """Return True if the file's pixels are exactly these, (H, W, C); False too where it cannot be read."""
    try:
        with open_picture(path, Settings(max_pixels=pixels.shape[0] * pixels.shape[1])) as file:
            names = file.specs[0].channelnames
            planes = file.read_native(0, names)
    except ReadError:
        return False
    return np.array_equal(np.stack([planes[name] for name in names], axis=2), pixels)
