"""Nodes that draw lines: isotropic DoG, flow-based DoG (FDoG), and FDoG in several passes.

Each draws in one of two forms: the paper's eqs. 8 and 9, or XDoG's.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from flowabs_nodes import filters
from flowabs_nodes.array_types import Array
from flowabs_nodes.choices import FDOG_KERNELS, FORMS
from flowabs_nodes.filters import halo
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.common_params import GROUND, SPACE, sampling
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.regions import within

IMAGE = Port("image", "color", "The picture to draw.")
FLOW = Port("flow", "flow", "The flow that lines follow.")
LINES = Port("lines", "matte", "The drawing: 1 is paper, 0 is ink.")
RESPONSE = Port(
    "response",
    "mono",
    "The response before the threshold in code values, low where ink is: H, or in form xdog D, the sharpened picture.",
)

FORM = Param.enum(
    "form",
    "paper",
    FORMS,
    help="Which lines: the paper's, by rho, tau, contrast and softness, or XDoG's, which fade into tone, by p, epsilon "
    "and phi.",
)

#: The difference of Gaussians, eq. 8.
DIFFERENCE = (
    Param.float(
        "sigma_c",
        1.0,
        min=0.05,
        max=200,
        soft=(0.3, 4),
        unit="px",
        thin_below=1.0,
        help="Centre Gaussian: sets the width of the line.",
    ),
    Param.float(
        "rho",
        0.99,
        min=0,
        max=2,
        soft=(0.9, 1),
        help="Weight of the surround: more lines, and more noise, the nearer to 1. Form paper.",
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
        help="Threshold of eq. 9: higher draws more, 0 nothing. Form paper, and not used when contrast is set.",
    ),
    Param.float(
        "contrast",
        None,
        min=0,
        max=1000,
        soft=(0, 10),
        unit="code values",
        nullable=True,
        help="Ink where the response is below minus this; higher draws less. null: from tau, -atanh(tau - 1). "
        "Form paper.",
    ),
    Param.float(
        "softness",
        0.0,
        min=0,
        max=1000,
        soft=(0, 10),
        unit="code values",
        help="Width of the ramp from ink to paper: anti-aliased, steadier in motion. 0 is black and white (the paper). "
        "Form paper.",
    ),
)

#: XDoG's form of both.
XDOG = (
    Param.float(
        "p",
        20.0,
        min=0,
        max=1000,
        soft=(0, 100),
        help="Form xdog: strength of the edges; 0 is tone alone. Takes rho's place, as p / (1 + p).",
    ),
    Param.float(
        "epsilon",
        0.0,
        min=-10_000,
        max=10_000,
        soft=(0, 255),
        unit="code values",
        help="Form xdog: tone below this level darkens; 0 draws edges alone, 255 fills all but their bright sides.",
    ),
    Param.float(
        "phi",
        0.01,
        min=0,
        max=1000,
        soft=(0, 1),
        unit="per code value",
        help="Form xdog: steepness of the way to black; low is soft like pastel, high is black ink.",
    ),
)

#: What FDoG takes beside the parameters above.
ALONG_FLOW = (
    Param.float(
        "color_weight",
        0.0,
        min=0,
        max=10,
        soft=(0, 1),
        help="How much differences of colour add to those of lightness; 0 is lightness alone (the paper). Form paper.",
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
        FDOG_KERNELS,
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
    """Return the code values that FDoG sees: (H, W), lightness; (H, W, 3) with two channels of colour where they count.

    The channels of colour are a* and b* (lab), or red and blue less lightness (acescct).
    """
    if color_weight == 0:
        return image.encoded_mono(space, ground=ground)
    codes = image.encoded(space, ground=ground)
    if space == "lab":
        return codes
    lightness = image.encoded_mono(space, ground=ground)
    return np.stack([lightness, codes[..., 0] - lightness, codes[..., 2] - lightness], axis=2)


def draw(
    respond: Callable[..., Array],
    *,
    form: str,
    rho: float,
    tau: float,
    contrast: float | None,
    softness: float,
    p: float,
    epsilon: float,
    phi: float,
    **response_params: Any,
) -> tuple[Array, Array]:
    """Return lines and response in either form; ``respond`` makes H from a rho and all parameters not named here."""
    if form == "xdog":
        return filters.xdog(respond(rho=filters.xdog_rho(p), **response_params), p=p, epsilon=epsilon, phi=phi)
    response = respond(rho=rho, **response_params)
    return filters.threshold(response, tau=tau, contrast=contrast, softness=softness), response


def outputs(image: Image, lines: Array, response: Array) -> dict[str, Image]:
    """Return both outputs as images, with the picture's windows and metadata."""
    return {"lines": image.with_pixels(lines, "matte"), "response": image.with_pixels(response, "mono")}


def smoothed(lines: Array, flow: Image, sigma: float, sampling: str) -> Array:
    """Return the lines, blurred along the flow unless ``sigma`` (pixels) is 0."""
    return lines if sigma == 0 else filters.flow_blur(lines, flow.pixels, sigma=sigma, sampling=sampling)


def run_dog(context: Context, image: Image, *, ground: float, space: str, **dog: Any) -> dict[str, Image]:
    code = image.encoded_mono(space, ground=ground)
    return outputs(image, *draw(partial(filters.dog, code), **dog))


def _dog_halo(params: Mapping[str, Any]) -> int:
    return halo.dog(params["sigma_c"])


DOG = Node(
    type="dog",
    version=1,
    label="DoG lines",
    category="compare",
    help="Lines by isotropic difference of Gaussians: what FDoG is compared with.",
    doc="Winnemoeller's edge model [38], which follows no flow. Response: eq. 8 in two dimensions; lines: eq. 9.",
    inputs=(IMAGE,),
    outputs=(LINES, RESPONSE),
    params=(FORM, *DIFFERENCE, *THRESHOLD, *XDOG, GROUND, SPACE),
    run=run_dog,
    region=within(_dog_halo, "image"),
)


def run_fdog(
    context: Context,
    image: Image,
    flow: Image,
    *,
    color_weight: float,
    smooth: float,
    ground: float,
    space: str,
    **fdog: Any,
) -> dict[str, Image]:
    color_weight = 0.0 if fdog["form"] == "xdog" else color_weight
    code = code_values(image, space, ground, color_weight)
    lines, response = draw(partial(filters.fdog, code, flow.pixels, color_weight=color_weight), **fdog)
    return outputs(image, smoothed(lines, flow, smooth, fdog["sampling"]), response)


def _fdog_halo(params: Mapping[str, Any]) -> int:
    return halo.fdog(params["sigma_m"], params["sigma_c"]) + halo.flow_blur(params["smooth"])


FDOG = Node(
    type="fdog",
    version=1,
    label="FDoG lines",
    category="lines",
    help="Lines by flow-based difference of Gaussians.",
    doc=(
        "Section 3.1, eqs. 6-11: a difference of Gaussians across the flow, gathered along it, so that true edges add "
        "up and noise does not. With rho = 1 and a contrast, the amount of line does not depend on brightness."
    ),
    inputs=(IMAGE, FLOW),
    outputs=(LINES, RESPONSE),
    params=(FORM, SIGMA_M, *DIFFERENCE, *THRESHOLD, *XDOG, *ALONG_FLOW),
    run=run_fdog,
    region=within(_fdog_halo, "image", "flow"),
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
    color_weight = 0.0 if fdog_iterative["form"] == "xdog" else color_weight
    code = code_values(image, space, ground, color_weight)
    lines, response = filters.fdog_iterative(code, flow.pixels, color_weight=color_weight, **fdog_iterative)
    return outputs(image, smoothed(lines, flow, smooth, fdog_iterative["sampling"]), response)


def _fdog_iterative_halo(params: Mapping[str, Any]) -> int:
    passes = halo.fdog_iterative(params["sigma_m"], params["sigma_c"], params["iterations"], params["pre_blur"])
    return passes + halo.flow_blur(params["smooth"])


FDOG_ITERATIVE = Node(
    type="fdog_iterative",
    version=1,
    label="FDoG lines, iterative",
    category="lines",
    help="FDoG in several passes, each drawn over the picture for the next: harder, longer, more connected lines.",
    doc=(
        "Section 3.2: the ink of the last pass is laid over the original, the flow stays, and FDoG runs again. "
        "One pass looks like pencil, two like pen, three like brush."
    ),
    inputs=(IMAGE, FLOW),
    outputs=(LINES, RESPONSE),
    params=(
        FORM,
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
        *XDOG,
        *ALONG_FLOW,
    ),
    run=run_fdog_iterative,
    region=within(_fdog_iterative_halo, "image", "flow"),
)
