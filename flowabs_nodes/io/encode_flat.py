"""A picture as the bytes of a PNG or TIFF file: one image to look at, on its display window."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Mapping

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes import color
from flowabs_nodes.color import ocio
from flowabs_nodes.errors import WriteError
from flowabs_nodes.image import Image
from flowabs_nodes.io import alpha as alphas
from flowabs_nodes.io import attributes, formats, nonfinite, provenance
from flowabs_nodes.io.image_file import open_picture, reason
from flowabs_nodes.io.output_image import Picture, main_planes
from flowabs_nodes.io.settings import Settings

Say = Callable[[str], None]

_EXTENSIONS = {"png": ".png", "tiff": ".tif"}
_CAN_HOLD = {"png": ("uint8", "uint16"), "tiff": ("uint8", "uint16", "float")}
_BASETYPES = {oiio.UINT8: "uint8", oiio.UINT16: "uint16", oiio.FLOAT: "float"}
_SRGB = "srgb_rec709_scene"


def encode_flat(picture: Picture, kind: str, marks: Mapping[str, str], warn: Say) -> bytes:
    """The file: colour encoded for the screen, alpha straight; mattes and mono as they are."""
    image = picture.image
    if image.type in ("flow", "data"):
        raise WriteError(f"{formats.NAMES[kind]} cannot hold a {image.type} image; write an EXR", code="bad-format")
    if picture.layers:
        warn(f"{formats.NAMES[kind]} holds one image: layers {', '.join(picture.layers)} are left out")
    if picture.keep_layers:
        warn(f"{formats.NAMES[kind]} holds one image: the plate's other layers are left out")
    display = image.display_window
    if display.width * display.height > picture.settings.max_pixels:
        raise WriteError(f"a display window of {display.width}x{display.height} is too large", code="too-large")
    image = image.on_window(display)
    data_type = _data_type(picture, kind, warn)
    encoding = _encoding(picture, data_type)
    if encoding is None and image.type == "color" and image.colorspace != color.space("lin_rec709"):
        warn(f"{formats.NAMES[kind]} cannot say that its colours are {image.colorspace}; colorspace converts them")
    pixels = _quantised(_encoded(image, encoding, picture.settings, warn), data_type)
    spec = _spec(picture, kind, pixels, encoding, marks)
    return _through_oiio(kind, spec, pixels)


def _data_type(picture: Picture, kind: str, warn: Say) -> str:
    holds = _CAN_HOLD[kind]
    if picture.data_type in holds:
        return picture.data_type
    if picture.data_type != "auto":
        warn(f"{formats.NAMES[kind]} cannot hold {picture.data_type}: data_type auto is used")
    plate = _BASETYPES.get(picture.image.spec.format.basetype, "") if not picture.plate_is_exr else ""
    if plate in holds and picture.image.origin is not None:
        return plate
    return "uint16" if kind == "tiff" else "uint8"


def _encoding(picture: Picture, data_type: str) -> str | None:
    """The OCIO name of the file's colours; None where they are scene-linear as the image's, or no colours at all."""
    if picture.image.type != "color":
        return None
    if picture.colorspace != "plate":
        return picture.colorspace
    photographed = data_type != "float"
    detected = color.detect(picture.image.spec, ocio=picture.settings.ocio, display_referred=photographed)
    if detected.encoding is not None and not picture.plate_is_exr:
        return detected.encoding
    return _SRGB if photographed else None


def _encoded(image: Image, encoding: str | None, settings: Settings, warn: Say) -> npt.NDArray[np.float32]:
    """(H, W, 3 or 4): straight colour in its encoding, or scene-linear and premultiplied."""
    pixels = image.pixels
    nans, _ = nonfinite.count(pixels)
    if nans:
        warn(f"image: {nans} NaN written as 0")
        pixels = np.nan_to_num(pixels, nan=0.0, posinf=np.inf, neginf=-np.inf)
    planes = main_planes(image, pixels)
    if encoding is None:
        return np.stack(list(planes.values()), axis=2)
    rgb = pixels[..., :3]
    if "A" in planes:
        rgb = alphas.straight(rgb, planes["A"])
    rgb = ocio.encode_named(rgb, image.colorspace, encoding, settings.ocio)
    return np.concatenate([rgb, pixels[..., 3:]], axis=2)


def _quantised(pixels: npt.NDArray[np.float32], data_type: str) -> npt.NDArray[np.generic]:
    if data_type == "float":
        return pixels
    scale = np.float32(255 if data_type == "uint8" else 65535)
    return np.asarray(np.clip(pixels, 0, 1) * scale + np.float32(0.5)).astype(data_type)


def _spec(
    picture: Picture, kind: str, pixels: npt.NDArray[np.generic], encoding: str | None, marks: Mapping[str, str]
) -> oiio.ImageSpec:
    """A header with the image's metadata, and the stamps where the format keeps them."""
    height, width, count = pixels.shape
    spec = oiio.ImageSpec(width, height, count, "float" if pixels.dtype == np.float32 else str(pixels.dtype))
    same = picture.colorspace == "plate" and not picture.plate_is_exr and encoding is not None
    for attribute in picture.image.spec.extra_attribs:
        # A profile describes the plate's codes: true only where the same encoding is written.
        if attributes.describes_picture(attribute.name) or (same and attribute.name == "ICCProfile"):
            spec.attribute(attribute.name, attribute.type, attribute.value)
    for name, value in picture.metadata.items():
        spec.attribute(name, value)
    if kind == "tiff":
        lines = {name: str(value) for name, value in picture.metadata.items() if name != "ImageDescription"}
        text = provenance.in_description(spec.get_string_attribute("ImageDescription"), {**lines, **marks})
        spec.attribute("ImageDescription", text)
        spec.attribute("compression", "zip")
    else:
        for name, mark in marks.items():
            spec.attribute(name, mark)
    if encoding is not None:
        spec.attribute("oiio:ColorSpace", encoding)
        spec.attribute("oiio:UnassociatedAlpha", 1)
    return spec


def _through_oiio(kind: str, spec: oiio.ImageSpec, pixels: npt.NDArray[np.generic]) -> bytes:
    """OpenImageIO writes to files only: to a private one, whose pixels are compared before its bytes are taken."""
    with tempfile.TemporaryDirectory(prefix="flowabs-") as folder:
        path = os.path.join(folder, "picture" + _EXTENSIONS[kind])
        output = oiio.ImageOutput.create(kind)
        if output is None:
            raise WriteError(f"this OpenImageIO does not write {formats.NAMES[kind]}: {reason(oiio)}")
        wrong = ""
        if not output.open(path, spec):
            wrong = reason(output) or "it cannot be opened"
        elif not output.write_image(pixels):
            wrong = reason(output) or "its pixels cannot be written"
        if not output.close() and not wrong:
            wrong = reason(output) or "it cannot be closed"
        if not wrong and not _holds(path, pixels):
            wrong = "its pixels are not what was written"
        if wrong:
            raise WriteError(f"cannot be encoded as {formats.NAMES[kind]}: {wrong}")
        with open(path, "rb") as file:
            return file.read()


def _holds(path: str, pixels: npt.NDArray[np.generic]) -> bool:
    with open_picture(path, Settings(max_pixels=pixels.shape[0] * pixels.shape[1])) as file:
        names = file.specs[0].channelnames
        planes = file.read_native(0, names)
    return np.array_equal(np.stack([planes[name] for name in names], axis=2), pixels)
