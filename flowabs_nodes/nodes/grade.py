"""The nodes that grade a picture and invert one."""

from __future__ import annotations

from flowabs_nodes.comp.grading import graded, inverted
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.regions import pixelwise


def run_grade(
    context: Context, image: Image, *, exposure: float, gain: float, offset: float, gamma: float, saturation: float
) -> Image:
    return graded(image, exposure, gain, offset, gamma, saturation)


GRADE = Node(
    type="grade",
    version=1,
    label="Grade",
    category="tone",
    help="Grades in scene-linear light: exposure, gain, offset, gamma, saturation; alpha stays.",
    doc=(
        "In this order: (c x gain x 2^exposure + offset)^(1 / gamma), then saturation about the luminance of the "
        "picture's own colour space. It works on c, the colour divided by alpha, and multiplies by alpha again: "
        "offset and gamma leave no rim around an element, and what is transparent stays black. A glow, light where "
        "alpha is 0, takes gain, exposure and saturation alone. Numbers at or below zero are left out of gamma; "
        "nothing is clamped."
    ),
    inputs=(Port("image", "color", "The picture."),),
    outputs=(Port("image", "color", "The graded picture; alpha as it was."),),
    params=(
        Param.float(
            "exposure", 0.0, min=-30, max=30, soft=(-5, 5), unit="stops", help="+1 doubles the light, -1 halves it."
        ),
        Param.float("gain", 1.0, min=0, max=1e6, soft=(0, 4), help="Multiplies: white comes here."),
        Param.float("offset", 0.0, min=-1e6, max=1e6, soft=(-0.1, 0.1), help="Is added: black comes here."),
        Param.float(
            "gamma", 1.0, min=0.05, max=20, soft=(0.2, 5), help="Above 1 lifts what is between black and white."
        ),
        Param.float("saturation", 1.0, min=0, max=10, soft=(0, 2), help="0 is grey, 1 as it was."),
    ),
    run=run_grade,
    region=pixelwise("image"),
)


def run_invert(context: Context, image: Image, *, channels: str) -> Image:
    return inverted(image, channels)


INVERT = Node(
    type="invert",
    version=1,
    label="Invert",
    category="tone",
    help="Inverts: 1 - x, and of a picture with alpha alpha - x.",
    doc=(
        "alpha - x is 1 - x of the colour divided by alpha, premultiplied again: what is transparent stays black. "
        "Alpha itself stays unless it is named. A matte that is inverted masks the other part, and is 1 where it had "
        "no pixels: its data window grows to the display window."
    ),
    inputs=(Port("image", "color|mono|matte", "What to invert."),),
    outputs=(Port("image", "=image", "The inverted image."),),
    params=(
        Param.string(
            "channels",
            "",
            examples=("A", "R", "R,G", "*"),
            help='Channels to invert, names with commas: "" all but alpha, "*" all.',
        ),
    ),
    run=run_invert,
    windows="display",
    region=pixelwise("image"),
)
