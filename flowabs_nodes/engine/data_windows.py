"""Brings the inputs of a node to one data window, and refuses pictures of different sizes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image import Image, Window
from flowabs_nodes.port_types import pixel_type


def check_picture_size(name: str, image: Image, expected: Image, first: str) -> None:
    """Raise FlowabsError where the input ``name`` is of a picture of another size than the input ``first``.

    A proxy would cover one corner only. A picture that has pixels in a part of the frame only, its bounding box, has
    the display window of the whole.
    """
    found, wanted = image.display_window, expected.display_window
    if (found.width, found.height) == (wanted.width, wanted.height):
        return
    size = f"{wanted.width}x{wanted.height}"
    raise FlowabsError(
        f"input {name!r} is of a picture of {found.width}x{found.height}, but input {first!r} of {size}",
        code="window-mismatch",
        hint=f"resize the {name} to {size} (reformat); "
        "one of a part of the picture needs the display window of the whole",
    )


def on_union(images: Mapping[str, Image]) -> dict[str, Image]:
    """Return images on the smallest data window that holds all of theirs, transparent where they had no pixels.

    A color image without alpha that has to grow gets one, which is 1 where it had pixels. All must be of pictures of
    the size of the first one, else FlowabsError (window-mismatch) is raised.
    """
    first = next(iter(images))
    for name, image in images.items():
        check_picture_size(name, image, images[first], first)
    union = around(*(image.data_window for image in images.values()))
    return {name: image if image.data_window == union else with_alpha(image).on_window(union)
            for name, image in images.items()}  # fmt: skip


def on_display(image: Image) -> Image:
    """Return a mono or a matte on a data window that also holds its display window, any other image as it is."""
    if image.type == "color" or "color" not in pixel_type(image.type).widens_to:
        return image
    return image.on_window(around(image.data_window, image.display_window))


def around(*windows: Window) -> Window:
    """Return the smallest window that holds all of these."""
    left, top = min(window.x for window in windows), min(window.y for window in windows)
    right, bottom = max(each.x + each.width for each in windows), max(each.y + each.height for each in windows)
    return Window(left, top, right - left, bottom - top)


def with_alpha(image: Image) -> Image:
    """Return a color image with its alpha, 1 everywhere if it has none; any other image as it is."""
    if image.type != "color" or "A" in image.channels:
        return image
    opaque = np.ones((*image.pixels.shape[:2], 1), np.float32)
    return image.with_pixels(np.concatenate([image.pixels, opaque], axis=2))
