"""Make a picture to look at of an image, by its port type."""

from __future__ import annotations

import numpy as np
import OpenImageIO as oiio

from flowabs_nodes.color import ocio as named_spaces
from flowabs_nodes.image import Image
from flowabs_nodes.looking.color import look_at_color
from flowabs_nodes.looking.look import Look
from flowabs_nodes.port_types import pixel_type


def picture_of(image: Image, ocio: str | None = None) -> tuple[Image, str]:
    """Return a picture of an image of any type, and a sentence that says how it shows the image's numbers.

    The picture is a color image of three channels on the same windows: the light of a screen that shows it, white 1.
    Encoded as sRGB, as a PNG is by ``write``, it is what the screen is sent. ``ocio`` is the config whose default
    display and view colour is seen through (a path, or "ocio://..."), None the built-in one.

    Raises
    ------
    ColorError
        The config cannot be read or used.
    """
    look: Look = look_at_color(image, ocio) if image.type == "color" else pixel_type(image.type).look_function()(image)
    light, space = named_spaces.linearize(look.codes.clip(0, 1), look.encoding)
    source = image.spec
    spec = oiio.ImageSpec(source.width, source.height, 3, "float")  # the plate's tags are not true of the picture
    spec.x, spec.y = source.x, source.y
    spec.full_x, spec.full_y = source.full_x, source.full_y
    spec.full_width, spec.full_height = source.full_width, source.full_height
    spec.attribute("PixelAspectRatio", source.get_float_attribute("PixelAspectRatio", 1.0))
    return Image(light, spec, "color", colorspace=space), look.said + _nonfinite(image)


def _nonfinite(image: Image) -> str:
    """Return how many of an image's numbers are NaN or Inf, as the end of a sentence; empty where none is."""
    count = 0 if image.pixels.dtype.kind != "f" else int((~np.isfinite(image.pixels)).sum())
    return f"; {count} NaN or Inf" if count else ""
