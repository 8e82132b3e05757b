"""The node that lays lines over a picture."""

from __future__ import annotations

import numpy as np

from flowabs_nodes import color, filters
from flowabs_nodes.array_types import Array
from flowabs_nodes.choices import MIXING_SPACES
from flowabs_nodes.finishing.deferred import with_operation
from flowabs_nodes.finishing.operations import Ink
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.regions import pixelwise


def run_composite(
    context: Context,
    image: Image,
    lines: Image,
    *,
    ink: tuple[float, float, float],
    opacity: float,
    space: str,
) -> dict[str, Image]:
    from flowabs_nodes.filters import validate  # what numba compiles is not imported for a declaration

    drawing = validate.plane("lines", lines.pixels[..., 0])
    results = {}
    if "image" in context.wanted or not context.wanted:
        if space == "linear":
            results["image"] = with_operation(image, Ink(drawing, ink, opacity))
        else:
            results["image"] = image.with_codes(_mixed_in_code_values(image, drawing, ink, opacity, space), space)
    if "ink" in context.wanted or not context.wanted:
        k = (1 - drawing) * np.float32(opacity)
        alone = np.empty((*k.shape, 4), np.float32)
        alone[..., :3] = k[..., None] * np.asarray(ink, np.float32)
        alone[..., 3] = k
        results["ink"] = image.with_pixels(alone, "color")
    return results


def _mixed_in_code_values(
    image: Image, drawing: Array, ink: tuple[float, float, float], opacity: float, space: str
) -> Array:
    """Return the code values (H, W, 3) of the picture with ink, mixed in ``space``; in light where there is none.

    A pixel of no luminance, or less, has no lightness to mix: its channels, some above and some below zero, would not
    come closer to the ink together.
    """
    codes = image.encoded(space)
    ink_code = color.encode(np.array([[ink]], np.float32), space=space, colorspace=image.colorspace)[0, 0]
    mixed = filters.composite(codes, drawing, ink=tuple(map(float, ink_code)), opacity=opacity)
    black = color.encode(np.zeros((1, 1, 3), np.float32), space=space)[0, 0, 0]
    dark = codes[..., 0] <= black
    if space == "acescct":  # one of its channels must be at or below zero, as all of them count in luminance
        dark |= (codes[..., 1] <= black) | (codes[..., 2] <= black)
    if dark.any():
        rgb = color.decode(codes[dark][None], space=space, colorspace=image.colorspace)
        inked = filters.composite(rgb, drawing[dark][None], ink, opacity)
        lightless = color.luminance(rgb, image.colorspace) <= 0
        inked_codes = color.encode(inked, space=space, colorspace=image.colorspace)
        mixed[dark] = np.where(lightless[..., None], inked_codes, mixed[dark][None])[0]
    return mixed


COMPOSITE = Node(
    type="composite",
    version=1,
    label="Composite",
    category="merge",
    help="Lays lines over a picture in any ink.",
    doc=(
        "With k = (1 - lines) x opacity: rgb (1 - k) + ink A k, alpha as it was. In linear light, highlights eat "
        "ink that is not fully opaque; space lab or acescct mixes in code values instead, as the eye sees it, but "
        "for pixels at or below zero luminance."
    ),
    inputs=(
        Port("image", "color", "The picture, usually flattened."),
        Port("lines", "matte", "The drawing: 1 is paper, 0 is ink."),
    ),
    outputs=(
        Port("image", "color", "The picture with lines."),
        Port("ink", "color", "The ink alone, premultiplied RGBA, to put over anything."),
    ),
    params=(
        Param.color("ink", (0.0, 0.0, 0.0), help="Colour of the ink, scene-linear."),
        Param.float("opacity", 1.0, min=0, max=1, soft=(0, 1), help="How much the ink covers."),
        Param.enum(
            "space",
            "linear",
            MIXING_SPACES,
            label="Mix in",
            help="Where ink and picture mix: in light, or in code values.",
        ),
    ),
    run=run_composite,
    region=pixelwise("image", "lines"),
)
