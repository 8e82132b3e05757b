"""Resizes pictures of any type: for ``--scale``, and for ``reformat``."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes.array_types import Array
from flowabs_nodes.comp.buffers import ALGO, finite
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image import Image, Window
from flowabs_nodes.port_types import pixel_type

_REACH = 3  # half the width of the widest filter, in pixels of the smaller picture


def rounded(value: float) -> int:
    """Return the whole number nearest to a value, the greater one of two."""
    return math.floor(value + 0.5)


def between(x0: float, y0: float, x1: float, y1: float) -> Window:
    """Return the window between two corners: edges are rounded to whole pixels, at least one apart."""
    left, top = rounded(x0), rounded(y0)
    return Window(left, top, max(1, rounded(x1) - left), max(1, rounded(y1) - top))


def resized(image: Image, data: Window, display: Window, filter: str, *, overshoot: bool) -> Image:
    """Return the picture with its display window mapped to ``display``, on the data window ``data``.

    By the picture's type (:data:`flowabs_nodes.port_types.TYPES`) it is filtered by OpenImageIO's ``filter``, or taken
    from the nearest pixel; channels that are lengths in pixels grow or shrink as the display window does along their
    axis. Without ``overshoot`` each pixel is clamped to the range of the pixels that it covers in the image; with it,
    mattes and alpha alone are, to 0 to 1.

    Raises
    ------
    FlowabsError
        resize-failed, with what OpenImageIO says.
    """
    spec = image.spec
    spec.x, spec.y, spec.width, spec.height = data
    spec.full_x, spec.full_y, spec.full_width, spec.full_height = display
    declared = pixel_type(image.type)
    if declared.filtered:
        pixels = _filtered(image, data, display, filter)
        pixels = _within_coverage(image, pixels) if overshoot else _without_overshoot(pixels, image, data, display)
    else:
        pixels = _nearest(image, data, display)
    if declared.lengths:
        full = image.display_window
        factors = {"x": display.width / full.width, "y": display.height / full.height}
        pixels = pixels * np.array([factors[axis] for axis in declared.lengths], pixels.dtype)
    return Image(pixels, spec, image.type, colorspace=image.colorspace, origin=image.origin)


def fitted(image: Image, width: int, height: int, fit: str, filter: str) -> Image:
    """Return the picture in another format: a display window of ``width`` x ``height`` whose corner is at 0, 0.

    ``fit`` is one of :data:`flowabs_nodes.choices.FITS`. The picture lies in the middle. Its data window goes with it:
    what lies beyond the format stays, and what the format has beyond the picture is not in it. ArgumentError where the
    filter meets a pixel that is not finite, or leaves float32.
    """
    full, data = image.display_window, image.data_window
    across, down = width / full.width, height / full.height
    if fit != "distort":
        across = down = {"letterbox": min(across, down), "width": across, "height": down}[fit]
    inner_width, inner_height = max(1, rounded(full.width * across)), max(1, rounded(full.height * down))
    place = Window((width - inner_width) // 2, (height - inner_height) // 2, inner_width, inner_height)
    x, y = place.width / full.width, place.height / full.height
    corner_x, corner_y = place.x - full.x * x, place.y - full.y * y
    target = between(
        corner_x + data.x * x,
        corner_y + data.y * y,
        corner_x + (data.x + data.width) * x,
        corner_y + (data.y + data.height) * y,
    )
    format = Window(0, 0, width, height)
    still = (target, place) == (data, full)  # not a pixel moves
    result = image if still else resized(image, target, place, filter, overshoot=True)
    if pixel_type(image.type).filtered:
        finite(result.pixels, "reformat")
    spec = result.spec
    spec.full_x, spec.full_y, spec.full_width, spec.full_height = format
    return Image(result.pixels, spec, image.type, colorspace=image.colorspace, origin=image.origin)


def _places(image: Image, display: Window, positions: npt.NDArray[Any], axis: int) -> npt.NDArray[Any]:
    """Map positions along an axis (0 is x, 1 is y) of the resized plane to positions in the image's columns or rows.

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


def _filtered(image: Image, data: Window, display: Window, filter: str) -> Array:
    """Resize with one of OpenImageIO's filters."""
    # OIIO reads black outside the data window: with the border repeated, as the filters have it, no rim appears.
    x, y, width, height = image.data_window
    rim = math.ceil(_REACH * max(width / data.width, height / data.height)) + 2
    padded = np.pad(image.pixels, ((rim, rim), (rim, rim), (0, 0)), mode="edge")
    source = _buffer(
        Window(x - rim, y - rim, width + 2 * rim, height + 2 * rim), image.display_window, len(image.channels)
    )
    source.set_pixels(source.roi, padded)
    result = _buffer(data, display, len(image.channels))
    if not ALGO.resize(result, source, filter):
        raise FlowabsError(f"cannot be resized: {result.geterror()}", code="resize-failed")
    return np.asarray(result.get_pixels(oiio.FLOAT), np.float32).reshape(data.height, data.width, -1)


def _within_coverage(image: Image, pixels: Array) -> Array:
    """Return the pixels of a picture with a matte, or alpha, clamped to 0 to 1."""
    if image.type == "matte":
        return np.clip(pixels, 0, 1)
    if "A" in image.channels:
        pixels = pixels.copy()
        np.clip(pixels[..., 3], 0, 1, out=pixels[..., 3])
    return pixels


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
