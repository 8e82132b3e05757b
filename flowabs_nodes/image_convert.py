"""Convert pictures from NumPy arrays and OpenImageIO ImageBufs to pixels with a header, and back.

The functions here know nothing of :class:`~flowabs_nodes.image.Image`, which calls them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes import color
from flowabs_nodes.array_types import Array
from flowabs_nodes.color.spaces import known
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.image_parts import Parts, Window
from flowabs_nodes.port_types import TYPES, PortType, pixel_type

if TYPE_CHECKING:
    from flowabs_nodes.color import ColorSpace

#: OpenImageIO's data types of whole numbers.
_WHOLE_NUMBERS = (oiio.UINT8, oiio.INT8, oiio.UINT16, oiio.INT16, oiio.UINT32, oiio.INT32)


def parts_of_array(array: npt.ArrayLike, type: PortType | None, channels: tuple[str, ...] | None) -> Parts:
    """Return the parts of an image of (H, W) or (H, W, C) numbers, which are copied.

    Without ``type`` and ``channels``, the number of channels decides: one is mono, two are flow, three or four color,
    more are data. ``channels`` that no such type has make data. ArgumentError for another shape or dtype.
    """
    pixels = np.asarray(array)
    if pixels.ndim not in (2, 3) or pixels.size == 0 or pixels.dtype.kind not in "fiub":
        raise ArgumentError(
            f"expected numbers of shape (H, W) or (H, W, C), found {pixels.dtype} {pixels.shape}", parameter="array"
        )
    pixels = pixels if pixels.ndim == 3 else pixels[..., None]
    height, width, count = pixels.shape
    if type is None:
        guess = {1: "mono", 2: "flow", 3: "color", 4: "color"}.get(count, "data")
        type = "data" if channels is not None and channels not in TYPES[guess].channels else guess
    declared = pixel_type(type)
    given, pixels = pixels, declared.cast(pixels, whole_floats=True)
    if np.may_share_memory(given, pixels):
        pixels = pixels.copy()
    if channels is None:
        channels = declared.channel_names(count) or tuple(f"channel{i}" for i in range(count))
    spec = oiio.ImageSpec(width, height, count, _oiio_type(pixels))
    return Parts(pixels, with_channels(spec, channels), type)


def decoded(parts: Parts, stored: np.dtype[Any], colorspace: ColorSpace | str) -> tuple[Parts, ColorSpace]:
    """Return the parts of an image made of an array in scene-linear light, and the space they are in.

    ``stored`` is the array's dtype. Under the name of an encoding (sRGB, a camera's log), color and mono are decoded,
    uint8 and uint16 after division by 255 or 65535, with alpha that is not premultiplied. ArgumentError for uint8 and
    uint16 pictures that are said to be linear, and for other whole numbers under an encoding. ColorError for a name
    that is no colour space.
    """
    whole = stored in (np.uint8, np.uint16)
    seen = parts.type == "color" or "color" in pixel_type(parts.type).widens_to
    if not seen or parts.type == "matte" or not _is_encoding(colorspace):
        if whole and seen:
            white = np.iinfo(stored).max
            raise ArgumentError(
                f"array: expected {parts.type} with white at 1, found {stored} with white at {white}",
                hint=f"divide by {white}"
                + ("" if parts.type == "matte" else ', or colorspace="sRGB" for a picture as screens show it'),
                parameter="array",
            )
        if seen and parts.type != "mono" and stored.kind in "iu" and parts.pixels.max() > 8:  # no light
            raise ArgumentError(
                f"array: expected {parts.type} with white at 1, found {stored} up to {parts.pixels.max():g}",
                hint='as uint8 or uint16, with colorspace="sRGB", it is decoded'
                if parts.type == "color"
                else "divide by its white",
                parameter="array",
            )
        return parts, color.space(colorspace)
    if stored.kind != "f" and not whole:
        raise ArgumentError(
            f"array: expected uint8, uint16 or floats of {colorspace}, found {stored}", parameter="array"
        )
    pixels = parts.pixels / np.float32(np.iinfo(stored).max) if whole else parts.pixels
    count = pixels.shape[2]
    rgb, space = color.ocio.linearize(np.repeat(pixels, 3, axis=2) if count == 1 else pixels, str(colorspace))
    if count == 4:
        rgb[..., :3] *= rgb[..., 3:]
    return parts._replace(pixels=np.ascontiguousarray(rgb[..., :count])), space


def _is_encoding(colorspace: ColorSpace | str) -> bool:
    """Return True for the name of code values, such as sRGB; False for a scene-linear space, and for data."""
    if not isinstance(colorspace, str) or not colorspace or known(colorspace) is not None:
        return False
    from flowabs_nodes.color import named  # imports OpenColorIO, which known spaces do not need

    return named.find(colorspace).kind not in ("linear", "data")


def parts_of_imagebuf(buf: oiio.ImageBuf, type: PortType | None, layer: str) -> Parts:
    """Return the parts of an image of an ImageBuf's pixels; channels are found by name.

    With ``type`` None all channels are kept: exactly those of a type make that type, the first that is declared with
    them (a lone Y is mono), and any others data. Otherwise only the channels of that type in ``layer`` are kept ("" =
    the plain names). Ids are whole numbers in the buffer. ArgumentError for a buffer without flat pixels, or without
    the channels of ``type``.
    """
    spec = buf.spec()
    flat = spec.nchannels > 0 and not spec.deep  # OpenImageIO crashes when it is asked for other pixels
    pixels = buf.get_pixels(oiio.FLOAT) if flat else None
    if buf.has_error or pixels is None:
        found = "deep samples" if spec.deep else (buf.geterror() or "no pixels")
        raise ArgumentError(f"an ImageBuf with flat pixels is expected, found {found}", parameter="buf")
    pixels = np.asarray(pixels, np.float32).reshape(spec.height, spec.width, spec.nchannels)
    names = tuple(spec.channelnames)
    prefix = f"{layer}." if layer else ""
    whole = spec.format.basetype in _WHOLE_NUMBERS
    for declared in TYPES.values() if type is None else (pixel_type(type),):
        exact = declared.dtype.kind == "u"
        if type is None and exact and not whole:
            continue
        for wanted in reversed(declared.channels):
            picks = [prefix + name for name in wanted]
            if set(picks) == set(names) or (type is not None and set(picks) <= set(names)):
                if exact and whole:  # as they are, not scaled to 0..1
                    pixels = np.asarray(buf.get_pixels(spec.format)).reshape(pixels.shape)
                chosen = declared.cast(pixels[..., [names.index(pick) for pick in picks]], whole_floats=True)
                return Parts(chosen, with_channels(spec, wanted), declared.name)
    if type not in (None, "data"):
        expected = pixel_type(str(type)).expected_channels(prefix)
        raise ArgumentError(f"no channels {expected}; the buffer has {','.join(names)}", parameter="buf")
    return Parts(np.ascontiguousarray(pixels), with_channels(spec, names), "data")


def _oiio_type(pixels: npt.NDArray[np.generic]) -> str:
    """Return OpenImageIO's name of the data type of float32 or uint32 pixels."""
    return "float" if pixels.dtype.kind == "f" else "uint"


def imagebuf_of(pixels: Array, spec: oiio.ImageSpec) -> oiio.ImageBuf:
    """Return an ImageBuf of float32 or uint32 pixels (H, W, C) with the channels, windows and metadata of ``spec``."""
    spec = oiio.ImageSpec(spec)
    spec.set_format(oiio.TypeDesc(_oiio_type(pixels)))
    buf = oiio.ImageBuf(spec)
    buf.set_pixels(buf.roi, pixels)
    return buf


def with_channels(spec: oiio.ImageSpec, names: tuple[str, ...]) -> oiio.ImageSpec:
    """Return a copy of ``spec`` with these channels, all of its one data type."""
    copy = oiio.ImageSpec(spec)
    copy.nchannels = len(names)
    copy.channelnames = names
    copy.channelformats = ()
    copy.alpha_channel = names.index("A") if "A" in names else -1
    copy.z_channel = -1
    return copy


def on_window(pixels: Array, window: Window, wanted: Window, outside: float = 0.0) -> Array:
    """Return pixels (H, W, C) of the data window ``window`` on another: cut, and ``outside`` where there were none."""
    result = np.full((wanted.height, wanted.width, pixels.shape[2]), outside, pixels.dtype)
    x0, x1 = max(window.x, wanted.x), min(window.x + window.width, wanted.x + wanted.width)
    y0, y1 = max(window.y, wanted.y), min(window.y + window.height, wanted.y + wanted.height)
    if x0 < x1 and y0 < y1:
        shared = pixels[y0 - window.y : y1 - window.y, x0 - window.x : x1 - window.x]
        result[y0 - wanted.y : y1 - wanted.y, x0 - wanted.x : x1 - wanted.x] = shared
    return result
