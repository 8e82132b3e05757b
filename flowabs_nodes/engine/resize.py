"""Makes pictures smaller, for ``--scale``."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image import Image, Window
from flowabs_nodes.port_types import pixel_type

#: Sharp, so that lines drawn on the smaller picture are those of the full one. Its overshoot is cut off below.
FILTER = "lanczos3"
_REACH = 3  # half its width, in pixels of the smaller picture


def scale_window(window: Window, scale: float) -> Window:
    """Scale a window: both edges are rounded to whole pixels, at least one apart; equal windows stay equal."""
    x0, y0 = _rounded(window.x * scale), _rounded(window.y * scale)
    x1, y1 = _rounded((window.x + window.width) * scale), _rounded((window.y + window.height) * scale)
    return Window(x0, y0, max(1, x1 - x0), max(1, y1 - y0))


def _rounded(value: float) -> int:
    return math.floor(value + 0.5)


def scale_image(image: Image, scale: float) -> Image:
    """Return the picture with both windows scaled by ``scale``, above 0 up to 1; metadata and origin stay.

    By the picture's type (:data:`flowabs_nodes.port_types.TYPES`) it is filtered, or taken from the nearest pixel;
    channels that are lengths in pixels become as much shorter as the display window does along their axis.

    Raises
    ------
    FlowabsError
        resize-failed, with what OpenImageIO says.
    """
    if scale == 1:
        return image
    data, display = scale_window(image.data_window, scale), scale_window(image.display_window, scale)
    spec = image.spec
    spec.x, spec.y, spec.width, spec.height = data
    spec.full_x, spec.full_y, spec.full_width, spec.full_height = display
    declared = pixel_type(image.type)
    pixels = _filtered(image, data, display) if declared.filtered else _nearest(image, data, display)
    if declared.lengths:
        full = image.display_window
        factors = {"x": display.width / full.width, "y": display.height / full.height}
        pixels = pixels * np.array([factors[axis] for axis in declared.lengths], pixels.dtype)
    return Image(pixels, spec, image.type, colorspace=image.colorspace, origin=image.origin)


def _places(image: Image, display: Window, positions: npt.NDArray[Any], axis: int) -> npt.NDArray[Any]:
    """Map positions along an axis (0 is x, 1 is y) of the smaller plane to positions in the image's columns or rows.

    The display window is mapped to the display window, as in OpenImageIO.
    """
    shares = (positions - display[axis]) / display[axis + 2]
    full, data = image.display_window, image.data_window
    places: npt.NDArray[Any] = shares * full[axis + 2] + full[axis] - data[axis]
    return places


def _nearest(image: Image, data: Window, display: Window) -> Array:
    """Resize by taking the nearest pixel."""

    def indices(axis: int) -> npt.NDArray[np.intp]:
        centres = np.arange(data[axis], data[axis] + data[axis + 2]) + 0.5
        places = np.floor(_places(image, display, centres, axis)).astype(np.intp)
        clamped: npt.NDArray[np.intp] = np.clip(places, 0, image.data_window[axis + 2] - 1)
        return clamped

    return np.ascontiguousarray(image.pixels[np.ix_(indices(1), indices(0))])


def _filtered(image: Image, data: Window, display: Window) -> Array:
    """Resize with OpenImageIO's :data:`FILTER`."""
    # OIIO reads black outside the data window: with the border repeated, as the filters have it, no rim appears.
    x, y, width, height = image.data_window
    rim = math.ceil(_REACH * max(width / data.width, height / data.height)) + 2
    padded = np.pad(image.pixels, ((rim, rim), (rim, rim), (0, 0)), mode="edge")
    source = _buffer(
        Window(x - rim, y - rim, width + 2 * rim, height + 2 * rim), image.display_window, len(image.channels)
    )
    source.set_pixels(source.roi, padded)
    result = _buffer(data, display, len(image.channels))
    if not oiio.ImageBufAlgo.resize(result, source, FILTER):
        raise FlowabsError(f"cannot be resized: {result.geterror()}", code="resize-failed")
    pixels = np.asarray(result.get_pixels(oiio.FLOAT), np.float32).reshape(data.height, data.width, -1)
    return _without_overshoot(pixels, image, data, display)


def _buffer(data: Window, display: Window, channels: int) -> oiio.ImageBuf:
    """Make an ImageBuf of float channels with these windows."""
    spec = oiio.ImageSpec(data.width, data.height, channels, oiio.FLOAT)
    spec.x, spec.y = data.x, data.y
    spec.full_x, spec.full_y, spec.full_width, spec.full_height = display
    return oiio.ImageBuf(spec)


def _without_overshoot(pixels: Array, image: Image, data: Window, display: Window) -> Array:
    """Clamp each pixel to the range of the pixels that it covers in the image.

    So no dark rim appears beside a highlight, nothing becomes negative, and alpha 1 stays exactly 1.
    """
    low = high = np.pad(image.pixels, ((0, 1), (0, 1), (0, 0)), mode="edge")  # reduceat wants an index after the last
    for axis in (0, 1):
        size = image.data_window[axis + 2]
        edges = _places(image, display, np.arange(data[axis], data[axis] + data[axis + 2] + 1), axis)
        first = np.clip(np.floor(edges[:-1] + 1e-6).astype(np.intp), 0, size - 1)
        after = np.clip(np.ceil(edges[1:] - 1e-6).astype(np.intp), first + 1, size)
        bounds = np.stack(
            [first, after], axis=1
        ).ravel()  # every other range is from one pixel's end to the next's start
        low = np.minimum.reduceat(low, bounds, axis=1 - axis).take(np.arange(len(first)) * 2, axis=1 - axis)
        high = np.maximum.reduceat(high, bounds, axis=1 - axis).take(np.arange(len(first)) * 2, axis=1 - axis)
    return np.clip(pixels, low, high)
