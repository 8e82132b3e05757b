"""Makes pictures smaller, for ``--scale``."""

from __future__ import annotations

from flowabs_nodes.comp.resizing import between, resized
from flowabs_nodes.image import Image, Window

#: Sharp, so that lines drawn on the smaller picture are those of the full one. Its overshoot is cut off.
FILTER = "lanczos3"


def scale_window(window: Window, scale: float) -> Window:
    """Scale a window: both edges are rounded to whole pixels, at least one apart; equal windows stay equal."""
    x, y = window.x, window.y
    return between(x * scale, y * scale, (x + window.width) * scale, (y + window.height) * scale)


def scale_image(image: Image, scale: float) -> Image:
    """Return the picture with both windows scaled by ``scale``, above 0 up to 1; metadata and origin stay.

    No pixel leaves the range of those that it covers in the image. FlowabsError, code resize-failed, with what
    OpenImageIO says.
    """
    if scale == 1:
        return image
    data, display = scale_window(image.data_window, scale), scale_window(image.display_window, scale)
    return resized(image, data, display, FILTER, overshoot=False)
