"""The node that lays lines over a picture."""

from __future__ import annotations

import numpy as np

from flowabs_nodes import color, filters
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
            ink_code = color.encode(np.array([[ink]], np.float32), space=space, colorspace=image.colorspace)[0, 0]
            mixed = filters.composite(image.encoded(space), drawing, ink=tuple(map(float, ink_code)), opacity=opacity)
            results["image"] = image.with_codes(mixed, space)
    if "ink" in context.wanted or not context.wanted:
        k = (1 - drawing) * np.float32(opacity)
        alone = np.empty((*k.shape, 4), np.float32)
        alone[..., :3] = k[..., None] * np.asarray(ink, np.float32)
        alone[..., 3] = k
        results["ink"] = image.with_pixels(alone, "color")
    return results


COMPOSITE = Node(
    type="composite",
    version=1,
    label="Composite",
    category="merge",
    help="Lays lines over a picture in any ink.",
    doc=(
        "With k = (1 - lines) x opacity: rgb (1 - k) + ink A k, alpha as it was. In linear light, highlights eat "
        "ink that is not fully opaque; space lab or acescct mixes in code values instead, as the eye sees it."
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
