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

Color = tuple[float, float, float]

LSTAR = np.float32(2.55)  # code values per unit of L*


def run_composite(
    context: Context,
    image: Image,
    lines: Image,
    under: Image | None,
    *,
    ink: tuple[float, float, float],
    opacity: float,
    space: str,
    ink_tone: float,
    light_ink: tuple[float, float, float],
    light_below: float,
) -> dict[str, Image]:
    from flowabs_nodes.filters import validate  # what numba compiles is not imported for a declaration

    drawing = validate.plane("lines", lines.pixels[..., 0])
    wanted = context.wanted or {"image", "ink"}
    chosen: Color | Array = ink
    if ink_tone > 0 or light_below > 0:
        codes = (image if under is None else under).encoded("lab")  # not premultiplied, and of no colour space
        rgb = color.decode(codes, "lab", image.colorspace)
        chosen = filters.ink_color(rgb, codes[..., 0] / LSTAR, ink, ink_tone, light_ink, light_below)
    results = {}
    if "image" in wanted:
        if space != "linear":
            results["image"] = image.with_codes(_mixed_in_code_values(image, drawing, chosen, opacity, space), space)
        elif isinstance(chosen, np.ndarray):
            from flowabs_nodes.filters.compositing import inked

            results["image"] = image.with_pixels(inked(image.pixels, drawing, (0.0, 0.0, 0.0, opacity), colors=chosen))
        else:
            results["image"] = with_operation(image, Ink(drawing, chosen, opacity))
    if "ink" in wanted:
        k = (1 - drawing) * np.float32(opacity)
        alone = np.empty((*k.shape, 4), np.float32)
        alone[..., :3] = k[..., None] * np.asarray(chosen, np.float32)
        alone[..., 3] = k
        results["ink"] = image.with_pixels(alone, "color")
    return results


def _mixed_in_code_values(image: Image, drawing: Array, ink: Color | Array, opacity: float, space: str) -> Array:
    """Return the code values (H, W, 3) of the picture with ink, mixed in ``space``; in light where there is none.

    ``ink`` is scene-linear: three numbers, or (H, W, 3). A pixel of no luminance, or less, has no lightness to mix: its
    channels, some above and some below zero, would not come closer to the ink together.
    """
    codes = image.encoded(space)
    each = isinstance(ink, np.ndarray)
    inks = ink if isinstance(ink, np.ndarray) else np.array([[ink]], np.float32)
    ink_codes = color.encode(inks, space=space, colorspace=image.colorspace)
    mixed = filters.composite(codes, drawing, ink_codes if each else tuple(map(float, ink_codes[0, 0])), opacity)
    black = color.encode(np.zeros((1, 1, 3), np.float32), space=space)[0, 0, 0]
    dark = codes[..., 0] <= black
    if space == "acescct":  # one of its channels must be at or below zero, as all of them count in luminance
        dark |= (codes[..., 1] <= black) | (codes[..., 2] <= black)
    if dark.any():
        rgb = color.decode(codes[dark][None], space=space, colorspace=image.colorspace)
        inked = filters.composite(rgb, drawing[dark][None], inks[dark][None] if each else inks[0, 0], opacity)
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
        "for pixels at or below zero luminance. ink_tone makes ink a shade of what it lies on, of its hue, at an "
        "eighth of its light; light_below turns to light_ink on dark grounds, over a quarter of that lightness to "
        "either side. `under` says what the ink lies on, if it is not the picture: a `blur` of it gives one tone to "
        "both sides of a line, and keeps outlines of dark things against light ones dark."
    ),
    inputs=(
        Port("image", "color", "The picture, usually flattened."),
        Port("lines", "matte", "The drawing: 1 is paper, 0 is ink."),
        Port("under", "color", "What tone and lightness of the ink are taken from; else the picture.", optional=True),
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
        Param.float(
            "ink_tone",
            0.0,
            min=0,
            max=1,
            soft=(0, 1),
            group="Ink by what it lies on",
            help="How far ink is a darker shade of what it lies on rather than of its own colour.",
        ),
        Param.float(
            "light_below",
            0.0,
            min=0,
            max=100,
            soft=(0, 50),
            unit="L*",
            label="Light ink below",
            group="Ink by what it lies on",
            help="On grounds darker than this lightness the ink is light_ink; 0: nowhere.",
        ),
        Param.color(
            "light_ink",
            (0.8, 0.8, 0.8),
            group="Ink by what it lies on",
            help="Colour of the ink on dark grounds, scene-linear; beside light_below.",
        ),
    ),
    run=run_composite,
    region=pixelwise("image", "lines", "under"),
)
