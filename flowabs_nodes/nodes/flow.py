"""Nodes that make a flow, show it, and smooth along it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from flowabs_nodes import filters
from flowabs_nodes.choices import ETF_KERNELS
from flowabs_nodes.filters import halo
from flowabs_nodes.filters.working_scale import flow_factor
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.common_params import GROUND, SPACE, sampling
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.regions import pixelwise, within
from flowabs_nodes.nodes.working_scale import WORKING_SCALE, on_grid


def _reference_problem(value: Any) -> str | None:
    """Return what a gradient reference has to be if ``value`` is none; None if it is."""
    expected = '"max", a percentile such as "p99.5", or a finite number of at least 0 (code values/px)'
    if isinstance(value, str):
        if value == "max":
            return None
        digits = value[1:].replace(".", "", 1)
        fits = value.startswith("p") and digits.isascii() and digits.isdigit() and float(value[1:]) <= 100
        return None if fits else expected
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return None if number and math.isfinite(value) and value >= 0 else expected


@on_grid
def run_etf(
    context: Context,
    image: Image,
    mask: Image | None,
    edge_strength: Image | None,
    edge_flow: Image | None,
    *,
    gradient_reference: str | float,
    color: bool,
    ground: float,
    space: str,
    **etf: Any,
) -> Image:
    from flowabs_nodes.filters.flow.etf import (
        etf_and_reference,  # what numba compiles is not imported for a declaration
    )

    code = image.encoded(space, ground=ground) if color else image.encoded_mono(space, ground=ground)
    counts = None if mask is None else np.clip(mask.pixels[..., 0], 0, 1)
    edges: dict[str, Any] = {
        "edge_strength": None if edge_strength is None else edge_strength.pixels[..., 0],
        "edge_flow": None if edge_flow is None else edge_flow.pixels,
    }
    flow, reference = etf_and_reference(code, gradient_reference=gradient_reference, mask=counts, **edges, **etf)
    if isinstance(gradient_reference, str):
        context.note(f"gradient reference {gradient_reference} = {reference:.4g} code values/px")
    return image.with_pixels(flow, "flow")


def _etf_halo(params: Mapping[str, Any]) -> int | None:
    if params["fill"] is not None or params["adaptive"] or isinstance(params["gradient_reference"], str):
        return None
    radius, pre_blur = params["radius"], params["pre_blur"]
    factor = flow_factor(params["working_scale"], radius, pre_blur)
    return halo.etf(radius, params["iterations"], pre_blur, factor)


ETF = Node(
    type="etf",
    version=1,
    label="Edge tangent flow",
    category="flow",
    help="Edge tangent flow: a smooth field of directions along the picture's edges.",
    doc=(
        "Section 2 of the paper, eqs. 1-5. Each tangent becomes the mean of those around it, weighted towards strong "
        "gradients and similar directions, so that weak edges turn to follow the strong ones beside them. All other "
        "flow-based nodes follow what this one makes. Edges that a render's passes know (aov_lines) may be connected "
        "too: each counts as a gradient, so that the flow follows silhouettes that light and colour do not show."
    ),
    inputs=(
        Port("image", "color", "The picture whose edges to follow."),
        Port(
            "mask",
            "matte",
            "How much each pixel counts: at 0 it turns no tangent around it, and takes its own from there.",
            optional=True,
            cut=True,
        ),
        Port(
            "edge_strength",
            "mono",
            "Edges that passes know: how sure one is, 0 to 1.",
            optional=True,
            beside="edge_flow",
        ),
        Port("edge_flow", "flow", "The flow along these edges.", optional=True, beside="edge_strength"),
    ),
    outputs=(Port("flow", "flow", "Unit tangents, x right, y down; their sign has no meaning."),),
    params=(
        Param.float(
            "radius",
            5.0,
            min=0,
            max=500,
            soft=(2, 15),
            unit="px",
            group="Kernel",
            help="Radius of the kernel (mu, eq. 2): larger is smoother.",
        ),
        Param.int(
            "iterations",
            3,
            min=0,
            max=100,
            soft=(1, 5),
            group="Kernel",
            help="How many times the field is smoothed (section 2.3).",
        ),
        Param.enum(
            "kernel",
            "full",
            ETF_KERNELS,
            group="Kernel",
            help="The exact disc, or a pass along x and one along y in each iteration (section 2.4).",
        ),
        Param.float(
            "pre_blur",
            0.0,
            min=0,
            max=200,
            soft=(0, 4),
            unit="px",
            label="Blur before",
            group="Gradient",
            help="Gaussian blur of the picture before its gradient: against noise, and to join isolated points.",
        ),
        Param.custom(
            "gradient_reference",
            "max",
            schema={
                "description": '"max", "p" and a percentile, or a number from 0 (code values/px)',
                "anyOf": [
                    {"type": "number", "minimum": 0},
                    {"type": "string", "pattern": r"^(max|p(100(\.0*)?|[0-9]{1,2}(\.[0-9]*)?))$"},
                ],
            },
            parse=_reference_problem,
            scales=-1,
            unit="code values/px",
            group="Gradient",
            help='Gradient that counts as full strength: "max" of the frame, a percentile such as "p99.5", '
            "or a number, the same on every frame of a shot.",
        ),
        Param.float(
            "fill",
            0.0,
            min=0,
            max=1000,
            soft=(0, 8),
            unit="code values/px",
            nullable=True,
            label="Fill below",
            group="Gradient",
            help="Where the gradient is weaker than this, the direction leans on its surroundings; "
            "0 fills just what has no gradient at all, null leaves holes (the paper to the letter).",
        ),
        Param.bool(
            "adaptive",
            False,
            group="Kernel",
            help="A smaller kernel where texture is smaller than it: small shapes survive a large radius (section 6).",
        ),
        Param.bool(
            "color",
            False,
            label="Follow colour",
            group="Gradient",
            help="Follow edges of lightness and colour together; false is lightness alone (the paper).",
        ),
        Param.float(
            "edge_weight",
            60.0,
            min=0,
            max=1e6,
            soft=(0, 120),
            unit="code values/px",
            later=True,
            group="Gradient",
            help="Gradient that an edge of full strength in edge_strength counts as, beside the picture's own.",
        ),
        WORKING_SCALE,
        GROUND,
        SPACE,
    ),
    run=run_etf,
    region=within(_etf_halo, "image", "mask", "edge_strength", "edge_flow"),
)


def run_lic(context: Context, flow: Image, *, length: float, seed: int, contrast: float) -> Image:
    return flow.with_pixels(filters.lic(flow.pixels, length=length, seed=seed, contrast=contrast), "mono")


LIC = Node(
    type="lic",
    version=1,
    label="Line integral convolution",
    category="flow",
    help="Line integral convolution: shows a flow as streaks of noise.",
    doc="How the paper shows its flows (Fig. 3): white noise, averaged over round(length / 2) steps along it each way.",
    inputs=(Port("flow", "flow", "The flow to show."),),
    outputs=(Port("image", "mono", "Streaks along the flow, 0 to 1 around 0.5."),),
    params=(
        Param.float("length", 20.0, min=0, max=2000, soft=(4, 60), unit="px", help="Length of a streak."),
        Param.int(
            "seed", 1, min=0, max=2**31 - 1, soft=(0, 100), help="Which noise; the same seed gives the same noise."
        ),
        Param.float("contrast", 1.0, min=0, max=100, soft=(0.2, 3), help="Spread of the greys about 0.5."),
    ),
    run=run_lic,
)


def run_flow_color(context: Context, flow: Image) -> Image:
    return flow.with_pixels(filters.flow_color(flow.pixels), "color")


FLOW_COLOR = Node(
    type="flow_color",
    version=1,
    label="Flow as colour",
    category="flow",
    help="Shows a flow's orientation as colour.",
    doc="As in the paper's Fig. 5: each orientation has its own RGB, 0 to 1; opposite tangents look the same.",
    inputs=(Port("flow", "flow", "The flow to show."),),
    outputs=(Port("image", "color", "Orientation as RGB; grey where the flow is zero."),),
    params=(),
    run=run_flow_color,
    region=pixelwise("flow"),
)


def run_flow_blur(context: Context, image: Image, flow: Image, *, sigma: float, sampling: str) -> Image:
    return image.with_pixels(filters.flow_blur(image.pixels, flow.pixels, sigma=sigma, sampling=sampling))


def _flow_blur_halo(params: Mapping[str, Any]) -> int:
    return halo.flow_blur(params["sigma"])


FLOW_BLUR = Node(
    type="flow_blur",
    version=1,
    label="Blur along the flow",
    category="flow",
    help="Gaussian blur along the flow: smooths edges lengthwise and leaves them sharp across.",
    doc="On lines it is anti-aliasing along the stroke. Works on premultiplied RGBA.",
    inputs=(
        Port("image", "color|mono|matte", "What to blur."),
        Port("flow", "flow", "The flow to blur along."),
    ),
    outputs=(Port("image", "=image", "The blurred image."),),
    params=(
        Param.float(
            "sigma",
            2.0,
            min=0,
            max=500,
            soft=(0, 10),
            unit="px",
            label="Sigma along the flow",
            help="Standard deviation along the flow.",
        ),
        sampling("bilinear"),
    ),
    run=run_flow_blur,
    region=within(_flow_blur_halo, "image", "flow"),
)
