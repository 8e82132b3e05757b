"""What nodes that can work on a smaller picture declare: the parameter ``working_scale``, and where the grid lies.

A reduced pixel is a mean over a block of pixels. Blocks are counted from the corner of the display window: so a data
window, a crop, or the windows of a sequence do not move them, and a part of a picture is made of the same blocks as the
whole. Filters count blocks from the corner of their arrays; :func:`on_grid` makes the two the same.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import wraps
from typing import Any

import numpy as np

from flowabs_nodes.choices import WORKING_SCALES
from flowabs_nodes.image import Image, Window
from flowabs_nodes.nodes.declare import Context, Param

WORKING_SCALE = Param.enum(
    "working_scale",
    "full",
    WORKING_SCALES,
    group="Size",
    help="The size of the picture that is worked on. Long lengths need no full one: auto takes a smaller one "
    "where it looks the same.",
)

_GRID = 4  # pixels: the largest blocks, whose edges are also edges of the smaller ones

Result = Image | dict[str, Image]
Run = Callable[..., Any]


def on_grid(run: Run) -> Run:
    """Return a node's ``run`` whose pictures begin at a block of the grid: the border is repeated up to there."""

    @wraps(run)
    def on_whole_blocks(context: Context, **arguments: Any) -> Result:
        images = {name: each for name, each in arguments.items() if isinstance(each, Image)}
        first = next(iter(images.values()))
        window, full = first.data_window, first.display_window
        left, top = (window.x - full.x) % _GRID, (window.y - full.y) % _GRID
        if arguments[WORKING_SCALE.name] == "full" or left == top == 0:
            result: Result = run(context, **arguments)
            return result
        widened = {name: _widened(image, left, top) for name, image in images.items()}
        return _cut(run(context, **arguments | widened), window)

    return on_whole_blocks


def _widened(image: Image, left: int, top: int) -> Image:
    """Return an image with its border repeated to the left and to the top."""
    pixels = np.pad(image.pixels, ((top, 0), (left, 0), (0, 0)), "edge")
    spec = image.spec
    spec.x, spec.y, spec.width, spec.height = spec.x - left, spec.y - top, spec.width + left, spec.height + top
    return Image(pixels, spec, image.type, colorspace=image.colorspace, origin=image.origin)


def _cut(result: Result, window: Window) -> Result:
    """Return what a node made, cut to the data window that its inputs had."""
    if isinstance(result, Image):
        return result.on_window(window)
    cut: Mapping[str, Image] = {name: image.on_window(window) for name, image in result.items()}
    return dict(cut)
