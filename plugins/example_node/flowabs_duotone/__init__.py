"""A node for flowabs: ``duotone`` prints a picture in two inks, one for the shadows and one for the highlights."""

from __future__ import annotations

import numpy as np

from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.regions import pixelwise


def run_duotone(
    context: Context,
    image: Image,
    *,
    shadows: tuple[float, float, float],
    highlights: tuple[float, float, float],
    balance: float,
) -> Image:
    """Mix the two inks by lightness: L* 0 is all shadows, 100 all highlights, and above white it goes on."""
    lightness = image.encoded_mono("lab")[..., None] / np.float32(255)  # L* x 2.55 -> 0..1
    share = np.maximum(lightness, 0) ** np.float32(2.0**-balance)
    rgb = (1 - share) * np.asarray(shadows, np.float32) + share * np.asarray(highlights, np.float32)

    pixels = image.pixels.copy()  # an input is never changed in place
    if image.alpha is not None:
        rgb = np.where(image.alpha[..., None] > 0, rgb * image.alpha[..., None], pixels[..., :3])
    pixels[..., :3] = rgb
    return image.with_pixels(pixels)  # windows and metadata come along


DUOTONE = Node(
    type="duotone",
    version=1,
    label="Duotone print",
    category="tone",
    help="Prints the picture in two inks, one for shadows and one for highlights.",
    doc="Lightness (CIE L*) picks the mix of the two inks. Alpha stays; above white the mix goes on.",
    inputs=(Port("image", "color", "The picture."),),
    outputs=(Port("image", "color", "The print, scene-linear."),),
    params=(
        Param.color("shadows", (0.01, 0.02, 0.08), help="Ink of the darkest parts, scene-linear."),
        Param.color("highlights", (1.0, 0.9, 0.7), help="Ink of the brightest parts, scene-linear."),
        Param.float("balance", 0.0, min=-4, max=4, soft=(-1, 1), unit="stops", help="Above 0 towards the highlights."),
    ),
    run=run_duotone,
    region=pixelwise("image"),  # each pixel from itself alone
)
