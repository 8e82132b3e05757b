"""Convert pictures from NumPy arrays and OpenImageIO ImageBufs to pixels with a header, and back.

The functions here know nothing of :class:`~flowabs_nodes.image.Image`, which calls them.
"""

from __future__ import annotations

from typing import cast

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.image_parts import Parts, Window
from flowabs_nodes.port_types import CHANNELS, PortType, channel_names, expected_channels


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
    pixels = np.array(pixels if pixels.ndim == 3 else pixels[..., None], np.float32, order="C")
    height, width, count = pixels.shape
    if type is None:
        guess: PortType = {1: "mono", 2: "flow", 3: "color", 4: "color"}.get(count, "data")  # type: ignore[assignment]
        type = "data" if channels is not None and channels not in CHANNELS.get(guess, ()) else guess
    if channels is None:
        channels = channel_names(type, count) or tuple(f"channel{i}" for i in range(count))
    spec = oiio.ImageSpec(width, height, count, "float")
    return Parts(pixels, with_channels(spec, channels), type)


def parts_of_imagebuf(buf: oiio.ImageBuf, type: PortType | None, layer: str) -> Parts:
    """Return the parts of an image of an ImageBuf's pixels; channels are found by name.

    With ``type`` None all channels are kept: exactly R, G, B[, A] make color, flow.x, flow.y flow, Y mono, and any
    others data. Otherwise only the channels of that type in ``layer`` are kept ("" = the plain names). ArgumentError
    for a buffer without flat pixels, or without the channels of ``type``.
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
    # A lone Y is a mono, unless a matte is asked for.
    kinds = [kind for kind in CHANNELS if type == kind or (type is None and kind != "matte")]
    for kind in kinds:
        for wanted in reversed(CHANNELS[kind]):
            picks = [prefix + name for name in wanted]
            if set(picks) == set(names) or (type is not None and set(picks) <= set(names)):
                chosen = np.ascontiguousarray(pixels[..., [names.index(pick) for pick in picks]])
                return Parts(chosen, with_channels(spec, wanted), cast(PortType, kind))
    if type not in (None, "data"):
        expected = expected_channels(cast(str, type), prefix)
        raise ArgumentError(f"no channels {expected}; the buffer has {','.join(names)}", parameter="buf")
    return Parts(np.ascontiguousarray(pixels), with_channels(spec, names), "data")


def imagebuf_of(pixels: Array, spec: oiio.ImageSpec) -> oiio.ImageBuf:
    """Return an ImageBuf of float32 pixels (H, W, C) with the channel names, windows and metadata of ``spec``."""
    spec = oiio.ImageSpec(spec)
    spec.set_format(oiio.FLOAT)
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


def on_window(pixels: Array, window: Window, wanted: Window) -> Array:
    """Return pixels (H, W, C) of the data window ``window`` on another window: cut, and 0 where there were none."""
    result = np.zeros((wanted.height, wanted.width, pixels.shape[2]), np.float32)
    x0, x1 = max(window.x, wanted.x), min(window.x + window.width, wanted.x + wanted.width)
    y0, y1 = max(window.y, wanted.y), min(window.y + window.height, wanted.y + wanted.height)
    if x0 < x1 and y0 < y1:
        shared = pixels[y0 - window.y : y1 - window.y, x0 - window.x : x1 - window.x]
        result[y0 - wanted.y : y1 - wanted.y, x0 - wanted.x : x1 - wanted.x] = shared
    return result
