"""Lengths that follow the picture's size (reference height, smaller pictures), and the smaller pictures themselves.

A graph that says ``"reference_height": 1080`` means its pixel lengths for a display window of that height: on another
plate they are multiplied by ``display height / reference height``, quantities per pixel divided by it. ``--scale 0.5``
makes the pictures that come in smaller; lengths follow, because the display window does.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes.engine.report import Note
from flowabs_nodes.errors import ArgumentError, FlowabsError
from flowabs_nodes.image import Array, Image, Window
from flowabs_nodes.nodes.declare import Node, Param

#: Never negative, so that no dark rim appears beside an HDR highlight, and sharper than a triangle.
RESIZE_FILTER = "blackman-harris"
_REACH = 1.5  # half its width, in pixels of the smaller picture


def check_scale(scale: Any) -> float:
    """``scale`` as a float above 0 up to 1."""
    if isinstance(scale, bool) or not isinstance(scale, int | float) or not 0 < scale <= 1:
        raise ArgumentError(f"scale: expected a number above 0 up to 1, found {scale!r}", parameter="scale")
    return float(scale)


# ---------------------------------------------------------------------- lengths


def length_factor(reference_height: float | None, scale: float, image: Image | None) -> float:
    """By how much a node's lengths grow: ``image`` is what it looks at, already resized by ``scale``."""
    if reference_height is None or image is None:
        return scale
    return image.display_window.height / reference_height


def has_lengths(declaration: Node) -> bool:
    """True for a node some of whose parameters follow the size of the picture."""
    return any(param.scales for param in declaration.all_params.values())


def scale_lengths(
    declaration: Node, params: Mapping[str, Any], factor: float
) -> tuple[dict[str, Any], tuple[Note, ...]]:
    """Parameters with lengths multiplied by ``factor`` and quantities per pixel divided by it, and what to warn of.

    A scaled value outside the parameter's hard range becomes the range's end.
    """
    scaled = dict(params)
    warnings = []
    for name, param in declaration.all_params.items():
        value = scaled.get(name)
        if not param.scales or factor == 1 or isinstance(value, bool) or not isinstance(value, int | float):
            continue
        wanted = value * factor**param.scales
        scaled[name] = fitting = _within(param, wanted)
        if fitting != wanted and not (param.kind == "int" and abs(fitting - wanted) <= 0.5):
            text = (
                f"{name} {value:g} x {factor**param.scales:g} = {wanted:g} is not {param.range_text}: {fitting:g} used"
            )
            warnings.append(Note(text, warning=True, once=f"range {name}"))
        if name == "sigma_c" and fitting < 1:
            text = f"sigma_c is {fitting:.3g} px at this size: below 1, lines change with the picture's size"
            warnings.append(Note(text, warning=True, once="sigma_c"))
    return scaled, tuple(warnings)


def _within(param: Param, value: float) -> float:
    if param.kind == "int":
        value = math.floor(value + 0.5)
    if param.max is not None:
        value = min(value, param.max)
    if param.min is not None and value <= param.min:
        value = math.nextafter(param.min, math.inf) if param.above else param.min
    return int(value) if param.kind == "int" else value


# ---------------------------------------------------------------------- pictures


def scale_window(window: Window, scale: float) -> Window:
    """Both edges rounded to whole pixels, at least one pixel wide and high; equal windows stay equal."""
    x0, y0 = _rounded(window.x * scale), _rounded(window.y * scale)
    x1, y1 = _rounded((window.x + window.width) * scale), _rounded((window.y + window.height) * scale)
    return Window(x0, y0, max(1, x1 - x0), max(1, y1 - y0))


def _rounded(value: float) -> int:
    return math.floor(value + 0.5)


def scale_image(image: Image, scale: float) -> Image:
    """The same picture with both windows smaller; metadata and origin stay.

    Color, mono and matte are filtered. Flow and data are taken from the nearest pixel: directions and ids have no mean.
    """
    if scale == 1:
        return image
    data, display = scale_window(image.data_window, scale), scale_window(image.display_window, scale)
    spec = image.spec
    spec.x, spec.y, spec.width, spec.height = data
    spec.full_x, spec.full_y, spec.full_width, spec.full_height = display
    pixels = _nearest(image, data, display) if image.type in ("flow", "data") else _filtered(image, spec, scale)
    return Image(pixels, spec, image.type, colorspace=image.colorspace, origin=image.origin)


def _filtered(image: Image, target: Any, scale: float) -> Array:
    """By OpenImageIO, which maps display window to display window."""
    # OIIO reads black outside the data window: with the border repeated, as the filters have it, no rim appears.
    rim = math.ceil((_REACH + 1) / scale) + 1
    padded = np.pad(image.pixels, ((rim, rim), (rim, rim), (0, 0)), mode="edge")
    spec = image.spec
    spec.x, spec.y, spec.width, spec.height = spec.x - rim, spec.y - rim, spec.width + 2 * rim, spec.height + 2 * rim
    buffers = []
    for layout in (spec, target):
        plain = oiio.ImageSpec(layout.width, layout.height, layout.nchannels, oiio.FLOAT)
        plain.x, plain.y = layout.x, layout.y
        plain.full_x, plain.full_y = layout.full_x, layout.full_y
        plain.full_width, plain.full_height = layout.full_width, layout.full_height
        buffers.append(oiio.ImageBuf(plain))
    source, result = buffers
    source.set_pixels(source.roi, padded)
    if not oiio.ImageBufAlgo.resize(result, source, RESIZE_FILTER):
        raise FlowabsError(f"cannot be resized: {result.geterror()}", code="resize-failed")
    pixels = np.ascontiguousarray(result.get_pixels(oiio.FLOAT), np.float32)
    pixels = pixels.reshape(target.height, target.width, target.nchannels)
    if image.type == "color" and "A" in image.channels:
        alpha = pixels[..., 3]
        alpha[np.abs(alpha - 1) < 1e-5] = 1  # the weights' sum is 1 but for rounding: opaque stays opaque
    return pixels


def _nearest(image: Image, data: Window, display: Window) -> Array:
    old_data, old_display = image.data_window, image.display_window

    def indices(axis: int) -> npt.NDArray[np.intp]:
        start, size = data[axis], data[axis + 2]
        centres = (np.arange(start, start + size) + 0.5 - display[axis]) / display[axis + 2]
        places = np.floor(centres * old_display[axis + 2]).astype(int) + old_display[axis] - old_data[axis]
        clamped: npt.NDArray[np.intp] = np.clip(places, 0, old_data[axis + 2] - 1)
        return clamped

    return np.ascontiguousarray(image.pixels[np.ix_(indices(1), indices(0))])
