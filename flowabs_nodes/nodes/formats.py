"""The nodes that change which pixels there are: constant, crop and reformat."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from flowabs_nodes.choices import FITS, RESIZE_FILTERS
from flowabs_nodes.comp.resizing import between, fitted
from flowabs_nodes.image import Image, Window
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.regions import pixelwise

_LONGEST = 65535  # of a side; together at most as many pixels as four 16K frames have
_MOST = 2**29

_SIZE = "the width and height of a picture, whole numbers such as [1920, 1080]"
_BOX = "left, top, right and bottom edges in pixels, such as [100, 50, 740, 410], or null"


def _wrong_size(value: Any) -> str | None:
    """Return what is wrong with a parameter ``size``; None where nothing is."""
    fits = (
        isinstance(value, list | tuple)
        and len(value) == 2
        and all(isinstance(each, int) and not isinstance(each, bool) and 1 <= each <= _LONGEST for each in value)
        and value[0] * value[1] <= _MOST
    )
    return None if fits else f"{_SIZE}, at most {_LONGEST} a side and {_MOST} pixels"


def _size(default: tuple[int, int], help: str) -> Param:
    """Return a parameter for the size of a picture to make."""
    return Param.custom(
        "size",
        list(default),
        schema={
            "description": _SIZE,
            "type": "array",
            "items": {"type": "integer", "minimum": 1, "maximum": _LONGEST},
            "minItems": 2,
            "maxItems": 2,
            "examples": [[64, 48], [1280, 720]],
        },
        parse=_wrong_size,
        scales=1,
        of_run=True,
        unit="px",
        help=help,
    )


def run_constant(context: Context, like: Image | None, *, color: tuple[float, ...], size: Sequence[int]) -> Image:
    width, height = like.data_window[2:] if like is not None else size
    pixels = np.full((height, width, 3), color, np.float32)
    return Image.from_array(pixels) if like is None else like.with_pixels(pixels, "color")


CONSTANT = Node(
    type="constant",
    version=1,
    label="Constant",
    category="utility",
    help="A picture of one colour.",
    doc=(
        "With `like` it has that image's windows, metadata and colour space, else `size` and linear Rec.709. It is "
        "opaque."
    ),
    inputs=(Port("like", "any", "Whose windows, metadata and colour space to take.", optional=True),),
    outputs=(Port("image", "color", "The colour everywhere."),),
    params=(
        Param.color("color", (0.0, 0.0, 0.0), help="The colour, scene-linear."),
        _size((1920, 1080), "Width and height without `like`; follows --scale."),
    ),
    run=run_constant,
    region=pixelwise("like"),
)


def _wrong_box(value: Any) -> str | None:
    """Return what is wrong with a parameter ``box``; None where nothing is."""
    if value is None:
        return None
    fits = (
        isinstance(value, list | tuple)
        and len(value) == 4
        and all(isinstance(each, int | float) and not isinstance(each, bool) for each in value)
        and all(math.isfinite(each) and abs(each) <= 2**24 for each in value)
        and value[0] < value[2]
        and value[1] < value[3]
    )
    return None if fits else f"{_BOX}; left less than right, top less than bottom"


def run_crop(context: Context, image: Image, *, box: Sequence[float] | None) -> Image:
    if box is None:
        return image
    wanted, data = between(*box), image.data_window
    left, top = max(wanted.x, data.x), max(wanted.y, data.y)
    right = min(wanted.x + wanted.width, data.x + data.width)
    bottom = min(wanted.y + wanted.height, data.y + data.height)
    if left >= right or top >= bottom:
        context.warn(f"the box {list(box)} has no pixel of the data window {tuple(data)}: one empty pixel is left")
        return image.on_window(Window(wanted.x, wanted.y, 1, 1))
    return image.on_window(Window(left, top, right - left, bottom - top))


CROP = Node(
    type="crop",
    version=1,
    label="Crop",
    category="utility",
    help="Cuts the data window to a box; the display window stays.",
    doc=(
        "Nuke's Crop without reformat: pixels stay where they are, and what is outside is transparent in a merge. As "
        "the display window stays, lengths of later nodes do too. Edges are pixel coordinates from the top left, "
        "right and bottom are the first not in it. They grow with the plate, as all lengths in px: in a graph with a "
        "`reference_size` they are meant at that size."
    ),
    inputs=(Port("image", "any", "What to cut."),),
    outputs=(Port("image", "=image", "The part inside of the box."),),
    params=(
        Param.custom(
            "box",
            None,
            schema={
                "description": _BOX,
                "type": ["array", "null"],
                "items": {"type": "number"},
                "minItems": 4,
                "maxItems": 4,
                "examples": [[8, 1, 15, 9], [100, 50, 740, 410]],
            },
            parse=_wrong_box,
            scales=1,
            unit="px",
            help="Edges [left, top, right, bottom]; null is everything.",
        ),
    ),
    run=run_crop,
    windows="own",
    region=pixelwise("image"),
)


def run_reformat(context: Context, image: Image, *, size: Sequence[int], filter: str, fit: str) -> Image:
    return fitted(image, size[0], size[1], fit, filter)


REFORMAT = Node(
    type="reformat",
    version=1,
    label="Reformat",
    category="utility",
    help="Resizes to another format; OpenImageIO filters.",
    doc=(
        "The display window becomes `size`, with its corner at 0, 0; the picture lies in the middle of it, and its "
        "data window goes along. What the format has beyond the picture is transparent in a merge, what the picture "
        "has beyond the format stays. Depth, ids, normals, flow, motion and data are taken from the nearest pixel, "
        "motion grows with the picture. Mattes and alpha are kept within 0 to 1. Lengths in px of nodes after it "
        "follow the new display window, where the graph has a `reference_size`: lines have the same look before and "
        "after. `size` itself is of the picture, whatever `reference_size` says; --scale makes it smaller."
    ),
    inputs=(Port("image", "any", "What to resize."),),
    outputs=(Port("image", "=image", "The picture in its new format."),),
    params=(
        _size((1920, 1080), "Width and height of the format; follows --scale."),
        Param.enum("filter", "blackman-harris", RESIZE_FILTERS, help="How pixels are weighed."),
        Param.enum("fit", "letterbox", FITS, help="How a picture of another shape is put into the format."),
    ),
    run=run_reformat,
    windows="own",
)
