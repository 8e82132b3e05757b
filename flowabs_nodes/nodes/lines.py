"""Nodes that draw lines: isotropic DoG, flow-based DoG (FDoG), and FDoG in several passes."""

from __future__ import annotations

from typing import Any

import numpy as np

from flowabs_nodes import filters
from flowabs_nodes.image import Array, Image
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.shared import GROUND, SPACE, sampling

IMAGE = Port("image", "color", "The picture to draw.")
FLOW = Port("flow", "flow", "The flow that lines follow.")
LINES = Port("lines", "matte", "The drawing: 1 is paper, 0 is ink.")
RESPONSE = Port(
    "response", "mono", "The filter's response H before the threshold, in code values; ink is where it is low."
)

#: The difference of Gaussians, eq. 8.
DIFFERENCE = (
    Param.float(
        "sigma_c", 1.0, min=0.05, max=200, soft=(0.3, 4), unit="px", help="Centre Gaussian: sets the width of the line."
    ),
    Param.float(
        "rho",
        0.99,
        min=0,
        max=2,
        soft=(0.9, 1),
        help="Weight of the surround: more lines, and more noise, the nearer to 1.",
    ),
)

#: From response to lines, eq. 9.
THRESHOLD = (
    Param.float(
        "tau",
        0.5,
        min=0,
        max=1,
        soft=(0, 1),
        help="Threshold of eq. 9: higher draws more, 0 nothing. Not used when contrast is set.",
    ),
    Param.float(
        "contrast",
        None,
        min=0,
        max=1000,
        soft=(0, 10),
        unit="code values",
        nullable=True,
        help="Ink where the response is below minus this; higher draws less. null: from tau, -atanh(tau - 1).",
    ),
    Param.float(
        "softness",
        0.0,
        min=0,
        max=1000,
        soft=(0, 10),
        unit="code values",
        help="Width of the ramp from ink to paper: anti-aliased, steadier in motion. 0 is black and white (the paper).",
    ),
)

#: What FDoG has beside the two above.
ALONG_FLOW = (
    Param.float(
        "color_weight",
        0.0,
        min=0,
        max=10,
        soft=(0, 1),
        help="How much differences of colour add to those of lightness; 0 is lightness alone (the paper).",
    ),
    Param.float(
        "smooth",
        0.0,
        min=0,
        max=200,
        soft=(0, 4),
        unit="px",
        help="Gaussian blur of the lines along the flow: anti-aliasing lengthwise.",
    ),
    Param.enum(
        "kernel",
        "separable",
        ("separable", "full"),
        help="Eqs. 10 and 11 (fast), or eq. 6 sampled point by point.",
    ),
    sampling("bilinear"),
    GROUND,
    SPACE,
)

SIGMA_M = Param.float(
    "sigma_m",
    3.0,
    min=0,
    max=500,
    soft=(1, 10),
    unit="px",
    help="Gaussian along the flow: longer, more coherent lines.",
)


def code_values(image: Image, space: str, ground: float, color_weight: float) -> Array:
    """Lightness alone, or with two colour-difference channels beside it where those count."""
    if color_weight == 0:
        return image.encoded_mono(space, ground=ground)
    codes = image.encoded(space, ground=ground)
    if space == "lab":
        return codes
    lightness = image.encoded_mono(space, ground=ground)
    return np.stack([lightness, codes[..., 0] - lightness, codes[..., 2] - lightness], axis=2)


def run_dog(
    context: Context,
    image: Image,
    *,
    sigma_c: float,
    rho: float,
    tau: float,
    contrast: float | None,
    softness: float,
    ground: float,
    space: str,
) -> dict[str, Image]:
    response = filters.dog(image.encoded_mono(space, ground=ground), sigma_c=sigma_c, rho=rho)
    lines = filters.threshold(response, tau=tau, contrast=contrast, softness=softness)
    return {"lines": image.with_pixels(lines, "matte"), "response": image.with_pixels(response, "mono")}


DOG = Node(
    type="dog",
    version=1,
    help="Lines by isotropic difference of Gaussians: what FDoG is compared with.",
    doc="Winnemoeller's edge model [38], which follows no flow. Response: eq. 8 in two dimensions; lines: eq. 9.",
    inputs=(IMAGE,),
    outputs=(LINES, RESPONSE),
    params=(*DIFFERENCE, *THRESHOLD, GROUND, SPACE),
    run=run_dog,
)


def run_fdog(
    context: Context,
    image: Image,
    flow: Image,
    *,
    tau: float,
    contrast: float | None,
    softness: float,
    color_weight: float,
    smooth: float,
    ground: float,
    space: str,
    **fdog: Any,
) -> dict[str, Image]:
    code = code_values(image, space, ground, color_weight)
    response = filters.fdog(code, flow.pixels, color_weight=color_weight, **fdog)
    lines = filters.threshold(response, tau=tau, contrast=contrast, softness=softness)
    lines = filters.flow_blur(lines, flow.pixels, sigma=smooth, sampling=fdog["sampling"])
    return {"lines": image.with_pixels(lines, "matte"), "response": image.with_pixels(response, "mono")}


FDOG = Node(
    type="fdog",
    version=1,
    help="Lines by flow-based difference of Gaussians.",
    doc=(
        "Section 3.1, eqs. 6-11: a difference of Gaussians across the flow, gathered along it, so that true edges add "
        "up and noise does not. With rho = 1 and a contrast, the amount of line does not depend on brightness."
    ),
    inputs=(IMAGE, FLOW),
    outputs=(LINES, RESPONSE),
    params=(SIGMA_M, *DIFFERENCE, *THRESHOLD, *ALONG_FLOW),
    run=run_fdog,
)


def run_fdog_iterative(
    context: Context,
    image: Image,
    flow: Image,
    *,
    color_weight: float,
    smooth: float,
    ground: float,
    space: str,
    **fdog_iterative: Any,
) -> dict[str, Image]:
    code = code_values(image, space, ground, color_weight)
    lines, response = filters.fdog_iterative(code, flow.pixels, color_weight=color_weight, **fdog_iterative)
    lines = filters.flow_blur(lines, flow.pixels, sigma=smooth, sampling=fdog_iterative["sampling"])
    return {"lines": image.with_pixels(lines, "matte"), "response": image.with_pixels(response, "mono")}


FDOG_ITERATIVE = Node(
    type="fdog_iterative",
    version=1,
    help="FDoG in several passes, each drawn over the picture for the next: harder, longer, more connected lines.",
    doc=(
        "Section 3.2: the ink of the last pass is laid over the original, the flow stays, and FDoG runs again. "
        "One pass looks like pencil, two like pen, three like brush."
    ),
    inputs=(IMAGE, FLOW),
    outputs=(LINES, RESPONSE),
    params=(
        Param.int("iterations", 3, min=1, max=100, soft=(1, 5), help="How many passes."),
        Param.float(
            "pre_blur",
            0.0,
            min=0,
            max=200,
            soft=(0, 3),
            unit="px",
            help="Gaussian blur of the picture before each pass.",
        ),
        SIGMA_M,
        *DIFFERENCE,
        *THRESHOLD,
        *ALONG_FLOW,
    ),
    run=run_fdog_iterative,
)
