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
from flowabs_nodes.filters import gaussian, halo
from flowabs_nodes.filters.lines.soft_reach import lengths as soft_edge_lengths
from flowabs_nodes.filters.working_scale import (
    evidence_factor,
    lines_factor,
    soft_edges_factor,
    step_of_smoothing,
    thin_lines_factor,
)
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.common_params import GROUND, SPACE
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.line_params import ALONG_FLOW, DIFFERENCE, FORM, SIGMA_M, SOFT, THIN, THRESHOLD, XDOG
from flowabs_nodes.nodes.regions import within
from flowabs_nodes.nodes.working_scale import on_grid

IMAGE = Port("image", "color", "The picture to draw.")
FLOW = Port("flow", "flow", "The flow that lines follow.")
#: As the mask of all other nodes it says where the node acts, but here the rest is paper.
INK_MASK = Port("mask", "matte", "Where to draw: ink is multiplied by it, the rest is paper.", optional=True, cut=True)
LINES = Port("lines", "matte", "The drawing: 1 is paper, 0 is ink.")
RESPONSE = Port(
    "response",
    "mono",
    "The response before the threshold in code values, low where ink is: H, or in form xdog D, the sharpened picture.",
)


def code_values(image: Image, space: str, ground: float, color_weight: float) -> Array:
    """Return the code values that FDoG sees: (H, W), lightness; (H, W, 3) with two channels of colour where they count.

    The channels of colour are a* and b* (lab), or red and blue less lightness (acescct).
    """
    if color_weight == 0:
        return image.encoded_mono(space, ground=ground)
    return image.encoded_opponent(space, ground=ground)


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


def outputs(image: Image, lines: Array, response: Array, mask: Image | None) -> dict[str, Image]:
    """Return both outputs as images, with the picture's windows and metadata."""
    drawing = image.with_pixels(within_mask(lines, mask), "matte")
    return {"lines": drawing, "response": image.with_pixels(response, "mono")}


def within_mask(lines: Array, mask: Image | None) -> Array:
    """Return 1 - (1 - lines) mask, (H, W): the drawing where the mask is 1, paper where it is 0 or less."""
    if mask is None:
        return lines
    ink = np.clip(mask.pixels[..., 0], 0, 1)
    return lines * ink + (1 - ink)  # where the mask is 1 no bit changes


def smoothed(lines: Array, flow: Image, sigma: float, sampling: str, working_scale: str) -> Array:
    """Return the lines, (H, W), blurred along the flow unless ``sigma`` (pixels) is 0."""
    if sigma == 0:
        return lines
    from flowabs_nodes.filters.flow.flow_blur import along  # what numba compiles is not imported for a declaration

    weights = gaussian.every(step_of_smoothing(working_scale, sigma), gaussian.half(sigma))
    blurred: Array = along(np.ascontiguousarray(lines[None]), flow.pixels, weights, sampling, ground=1.0)[0]
    return blurred


def run_dog(
    context: Context, image: Image, mask: Image | None, *, ground: float, space: str, **dog: Any
) -> dict[str, Image]:
    code = image.encoded_mono(space, ground=ground)
    return outputs(image, *draw(partial(filters.dog, code), **dog), mask)


def _dog_halo(params: Mapping[str, Any]) -> int:
    return halo.dog(params["sigma_c"])


DOG = Node(
    type="dog",
    version=1,
    label="DoG lines",
    category="compare",
    help="Lines by isotropic difference of Gaussians: what FDoG is compared with.",
    doc="Winnemoeller's edge model [38], which follows no flow. Response: eq. 8 in two dimensions; lines: eq. 9.",
    inputs=(IMAGE, INK_MASK),
    outputs=(LINES, RESPONSE),
    params=(FORM, *DIFFERENCE, *THRESHOLD, *XDOG, GROUND, SPACE),
    run=run_dog,
    region=within(_dog_halo, "image", "mask"),
)


@on_grid
def run_fdog(
    context: Context,
    image: Image,
    flow: Image,
    mask: Image | None,
    *,
    color_weight: float,
    evidence: float,
    lone_lines: float,
    smooth: float,
    ground: float,
    space: str,
    **fdog: Any,
) -> dict[str, Image]:
    if fdog["form"] == "xdog":
        color_weight = evidence = lone_lines = 0.0
    code = code_values(image, space, ground, color_weight)
    weights: dict[str, Any] = {"color_weight": color_weight, "evidence": evidence, "lone_lines": lone_lines}
    lines, response = draw(partial(filters.fdog, code, flow.pixels, **weights), **fdog)
    return outputs(image, smoothed(lines, flow, smooth, fdog["sampling"], fdog["working_scale"]), response, mask)


def _soft_reach(params: Mapping[str, Any]) -> float | None:
    """Return how soft the outlines are that are looked for, None where none are."""
    reach: float = params["soft_reach"]
    return reach if params["soft_lines"] > 0 else None


def _soft_factor(params: Mapping[str, Any]) -> int:
    """Return the factor at which soft outlines are looked for."""
    return soft_edges_factor(params["working_scale"], soft_edge_lengths(params["soft_reach"]).t)


def _thin(params: Mapping[str, Any], pre_blur: float = 0.0) -> tuple[float, int]:
    """Return the width of thin bright lines, and the factor at which they are looked for."""
    width = params["thin_lines"]
    return width, thin_lines_factor(params["working_scale"], width, params["sigma_c"], pre_blur)


def _fdog_halo(params: Mapping[str, Any]) -> int:
    sigma_m, sigma_c = params["sigma_m"], params["sigma_c"]
    factor = lines_factor(params["working_scale"], sigma_c)
    response = halo.fdog(sigma_m, sigma_c, _soft_reach(params), factor, _soft_factor(params), *_thin(params))
    return response + _halo_after(params, factor)


def _halo_after(params: Mapping[str, Any], factor: int, pre_blur: float = 0.0) -> int:
    """Return the halo of what follows the response in both nodes."""
    factor = max(factor, evidence_factor(params["working_scale"], params["sigma_c"], pre_blur))
    looked_for = max(params["evidence"], params["lone_lines"])
    return halo.evidence(params["sigma_m"], looked_for, factor) + halo.flow_blur(params["smooth"])


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
    inputs=(IMAGE, FLOW, INK_MASK),
    outputs=(LINES, RESPONSE),
    params=(FORM, SIGMA_M, *DIFFERENCE, *THRESHOLD, *XDOG, *SOFT, *THIN, *ALONG_FLOW),
    run=run_fdog,
    region=within(_fdog_halo, "image", "flow", "mask"),
)


@on_grid
def run_fdog_iterative(
    context: Context,
    image: Image,
    flow: Image,
    mask: Image | None,
    *,
    color_weight: float,
    smooth: float,
    ground: float,
    space: str,
    **fdog_iterative: Any,
) -> dict[str, Image]:
    from flowabs_nodes.filters.lines.fdog_iterative import Passes  # what numba compiles is not imported to declare

    color_weight = 0.0 if fdog_iterative["form"] == "xdog" else color_weight
    passes = Passes.checked(color_weight=color_weight, **fdog_iterative)
    # Code values that nobody else wants are held by the filter alone, which lets go of them.
    lines, response = passes.draw(code_values(image, space, ground, color_weight), flow.pixels)
    return outputs(
        image,
        smoothed(lines, flow, smooth, fdog_iterative["sampling"], fdog_iterative["working_scale"]),
        response,
        mask,
    )


def _fdog_iterative_halo(params: Mapping[str, Any]) -> int:
    lengths = params["sigma_m"], params["sigma_c"], params["iterations"], params["pre_blur"]
    factor = lines_factor(params["working_scale"], *lengths[1:])
    thin = _thin(params, params["pre_blur"])
    passes = halo.fdog_iterative(*lengths, _soft_reach(params), factor, _soft_factor(params), *thin)
    return passes + _halo_after(params, factor, params["pre_blur"])


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
    inputs=(IMAGE, FLOW, INK_MASK),
    outputs=(LINES, RESPONSE),
    params=(
        FORM,
        Param.int(
            "iterations", 3, min=1, max=100, soft=(1, 5), label="Passes", group="Passes", help="How many passes."
        ),
        Param.float(
            "pre_blur",
            0.0,
            min=0,
            max=200,
            soft=(0, 3),
            unit="px",
            label="Blur before",
            group="Passes",
            help="Gaussian blur of the picture before each pass.",
        ),
        SIGMA_M,
        *DIFFERENCE,
        *THRESHOLD,
        *XDOG,
        *SOFT,
        *THIN,
        *ALONG_FLOW,
    ),
    run=run_fdog_iterative,
    region=within(_fdog_iterative_halo, "image", "flow", "mask"),
)
