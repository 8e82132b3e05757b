"""Convert OpenImageIO ImageBufs to the parts of an image, and back; move pixels to another window.

The functions here know nothing of :class:`~flowabs_nodes.image.Image`, which calls them.
"""

from __future__ import annotations

import numpy as np
import OpenImageIO as oiio

from flowabs_nodes import color
from flowabs_nodes.array_types import Array
from flowabs_nodes.color import ColorSpace, dpx
from flowabs_nodes.color.detection import forget, without_stale
from flowabs_nodes.errors import ArgumentError, ColorError
from flowabs_nodes.image import light
from flowabs_nodes.image.header_text import with_readable_texts
from flowabs_nodes.image.numbers import Numbers, meaning
from flowabs_nodes.image.parts import Parts, Window, with_channels
from flowabs_nodes.port_types import TYPES, PortType, pixel_type

#: OpenImageIO's data types of whole numbers; those of photographs, which are sRGB unless their header says else.
_WHOLE_NUMBERS = (oiio.UINT8, oiio.INT8, oiio.UINT16, oiio.INT16, oiio.UINT32, oiio.INT32)
_PHOTOGRAPHED = (oiio.UINT8, oiio.UINT16)
#: Attributes that say that colours are not multiplied by alpha.
_STRAIGHT = ("oiio:UnassociatedAlpha", "tiff:UnassociatedAlpha")


def parts_of_imagebuf(
    buf: oiio.ImageBuf, colorspace: ColorSpace | str | None, type: PortType | None, layer: str
) -> tuple[Parts, ColorSpace]:
    """Return the parts of an image of an ImageBuf's pixels, and their scene-linear space; channels are found by name.

    With ``type`` None all channels are kept: exactly those of a type make that type, the first that is declared with
    them (a lone Y is mono), and any others data. Otherwise only the channels of that type in ``layer`` are kept ("" =
    the plain names). Ids are whole numbers in the buffer. Color and mono are decoded from ``colorspace``, a space or an
    encoding; None and "auto" ask the buffer's metadata. ArgumentError for a buffer without flat pixels, or without the
    channels of ``type``; ColorError for what is no colour space.
    """
    spec = _checked(buf)
    numbers = _numbers(buf, spec, colorspace)
    parts = _chosen(buf, spec, type, layer)
    straight = spec.get_int_attribute(_STRAIGHT[0]) != 0
    if pixel_type(parts.type).light and (straight or numbers.encoding is not None):
        numbers = Numbers(numbers.space, numbers.encoding, straight, True, numbers.kept)
        parts = parts._replace(pixels=light.decoded(parts.pixels, numbers))
        for name in _STRAIGHT:
            parts.spec.erase_attribute(name)
    return parts, numbers.kept


def _checked(buf: oiio.ImageBuf) -> oiio.ImageSpec:
    """Return the header of a buffer with flat pixels; ArgumentError for others, which OpenImageIO may crash on."""
    if not isinstance(buf, oiio.ImageBuf):
        raise ArgumentError(
            f"buf: an ImageBuf with flat pixels is expected, found {buf.__class__.__name__}",
            code="wrong-type",
            parameter="buf",
        )
    spec = buf.spec()
    if buf.has_error:
        found = " ".join(str(buf.geterror()).split("\n")[0].split()) or "an error"
    elif not buf.initialized or spec.nchannels == 0 or spec.width * spec.height == 0:
        found = "an empty one"
    elif spec.deep:
        found = "deep samples"
    elif spec.depth > 1:
        found = f"a volume of {spec.depth} planes"
    else:
        return with_readable_texts(spec)
    raise ArgumentError(f"an ImageBuf with flat pixels is expected, found {found}", parameter="buf")


def _numbers(buf: oiio.ImageBuf, spec: oiio.ImageSpec, colorspace: ColorSpace | str | None) -> Numbers:
    """Return what the numbers of a buffer mean: as ``colorspace`` says, or else its header."""
    if colorspace is not None and colorspace != "auto":
        return meaning(colorspace, None, None, floats=True)
    if not spec.get_string_attribute("oiio:ColorSpace") and dpx.declares(spec):
        found = color.detect(spec, dpx.declared(spec)[0])
    else:
        spec = spec if buf.file_format_name else without_stale(spec)
        photographed = buf.nativespec().format.basetype in _PHOTOGRAPHED
        found = color.detect(spec, display_referred=photographed)
    return Numbers(found.space, found.encoding, False, True, found.space)


def _chosen(buf: oiio.ImageBuf, spec: oiio.ImageSpec, type: PortType | None, layer: str) -> Parts:
    """Return the channels of a type, or all, as they are in a buffer: whole numbers scaled to 0..1, but for ids."""
    pixels = buf.get_pixels(oiio.FLOAT)
    if buf.has_error or pixels is None:  # a file that is read only now
        found = str(buf.geterror()) or "no pixels"
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


def true_of_light(spec: oiio.ImageSpec, type: PortType, colorspace: ColorSpace) -> oiio.ImageSpec:
    """Return the header with nothing on colours that is not true of an image's pixels, scene-linear in ``colorspace``.

    It may still hold the tags and the profile of the file that they were decoded from.
    """
    try:
        found = color.detect(spec)
        true = found.encoding is None and (type != "color" or found.space == colorspace)
    except ColorError:  # a tag that cannot be converted
        true = False
    if not true:
        forget(spec)
    if type == "color":
        spec.attribute("oiio:ColorSpace", colorspace.name)
    return spec


def imagebuf_of(pixels: Array, spec: oiio.ImageSpec) -> oiio.ImageBuf:
    """Return an ImageBuf of float32 or uint32 pixels (H, W, C) with the channels, windows and metadata of ``spec``."""
    spec = oiio.ImageSpec(spec)
    spec.set_format(oiio.TypeDesc("float" if pixels.dtype.kind == "f" else "uint"))
    buf = oiio.ImageBuf(spec)
    buf.set_pixels(buf.roi, pixels)
    return buf


def on_window(pixels: Array, window: Window, wanted: Window, outside: float = 0.0) -> Array:
    """Return pixels (H, W, C) of the data window ``window`` on another: cut, and ``outside`` where there were none."""
    result = np.full((wanted.height, wanted.width, pixels.shape[2]), outside, pixels.dtype)
    x0, x1 = max(window.x, wanted.x), min(window.x + window.width, wanted.x + wanted.width)
    y0, y1 = max(window.y, wanted.y), min(window.y + window.height, wanted.y + wanted.height)
    if x0 < x1 and y0 < y1:
        shared = pixels[y0 - window.y : y1 - window.y, x0 - window.x : x1 - window.x]
        result[y0 - wanted.y : y1 - wanted.y, x0 - wanted.x : x1 - wanted.x] = shared
    return result
