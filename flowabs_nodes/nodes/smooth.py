"""Nodes that smooth regions: the flow-based bilateral filter, rolling guidance, and the plain blur."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flowabs_nodes import filters
from flowabs_nodes.filters import halo
from flowabs_nodes.filters.working_scale import guidance_factor, regions_factor
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.common_params import SPACE, sampling
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.regions import within
from flowabs_nodes.nodes.working_scale import WORKING_SCALE, on_grid


@on_grid
def run_fbl(
    context: Context,
    image: Image,
    flow: Image,
    *,
    sigma_e: float,
    r_e: float,
    sigma_g: float,
    r_g: float,
    iterations: int,
    sampling: str,
    working_scale: str,
    space: str,
) -> Image:
    # By name and not by **: code values that nobody else wants are held by the filter alone, which can let go of them.
    codes = filters.fbl(
        image.encoded(space),
        flow.pixels,
        sigma_e=sigma_e,
        r_e=r_e,
        sigma_g=sigma_g,
        r_g=r_g,
        iterations=iterations,
        sampling=sampling,
        alpha=image.alpha,
        working_scale=working_scale,
    )
    return image.with_codes(codes, space)


def _fbl_halo(params: Mapping[str, Any]) -> int:
    sigma_e, sigma_g = params["sigma_e"], params["sigma_g"]
    factor = regions_factor(params["working_scale"], sigma_e, sigma_g)
    return halo.fbl(sigma_e, sigma_g, params["iterations"], factor)


FBL = Node(
    type="fbl",
    version=1,
    label="Flow-based bilateral",
    category="regions",
    help="Flow-based bilateral filter: flattens regions and cleans up the edges between them.",
    doc=(
        "Section 4.1, eqs. 12-14: in each iteration a bilateral filter along the flow, then one across it. Along the "
        "flow it repairs and smooths boundaries, across it it flattens regions."
    ),
    inputs=(
        Port("image", "color", "The picture to smooth."),
        Port("flow", "flow", "The flow that its edges follow."),
    ),
    outputs=(Port("image", "color", "The smoothed picture."),),
    params=(
        Param.float(
            "sigma_e",
            2.0,
            min=0,
            max=200,
            soft=(0, 10),
            unit="px",
            label="Sigma along",
            group="Along the flow",
            help="Gaussian along the flow; 0 leaves it out.",
        ),
        Param.float(
            "r_e",
            10.0,
            min=0,
            max=1e6,
            above=True,
            soft=(1, 100),
            unit="code values",
            label="Colour range along",
            group="Along the flow",
            help="Difference of colour that still counts as alike along the flow: higher loses more small edges.",
        ),
        Param.float(
            "sigma_g",
            0.5,
            min=0,
            max=200,
            soft=(0, 5),
            unit="px",
            label="Sigma across",
            group="Across the flow",
            help="Gaussian across the flow; 0 leaves it out.",
        ),
        Param.float(
            "r_g",
            10.0,
            min=0,
            max=1e6,
            above=True,
            soft=(1, 100),
            unit="code values",
            label="Colour range across",
            group="Across the flow",
            help="Difference of colour that still counts as alike across the flow.",
        ),
        Param.int("iterations", 5, min=0, max=100, soft=(1, 10), help="How many times both passes run."),
        sampling("nearest"),
        WORKING_SCALE,
        SPACE,
    ),
    run=run_fbl,
    region=within(_fbl_halo, "image", "flow"),
)


@on_grid
def run_rolling_guidance(
    context: Context,
    image: Image,
    *,
    sigma_s: float,
    sigma_r: float,
    iterations: int,
    working_scale: str,
    space: str,
) -> Image:
    if sigma_s == 0:
        return image
    codes = filters.rolling_guidance(
        image.encoded(space),
        sigma_s=sigma_s,
        sigma_r=sigma_r,
        iterations=iterations,
        alpha=image.alpha,
        working_scale=working_scale,
    )
    return image.with_codes(codes, space)


def _rolling_guidance_halo(params: Mapping[str, Any]) -> int:
    factor = guidance_factor(params["working_scale"], params["sigma_s"])
    return halo.rolling_guidance(params["sigma_s"], params["iterations"], factor)


ROLLING_GUIDANCE = Node(
    type="rolling_guidance",
    version=1,
    label="Rolling guidance",
    category="regions",
    help="Removes detail smaller than a scale, keeps the edges of all that is larger: grass and tiles become flat.",
    doc=(
        "Zhang, Shen, Xu, Jia: Rolling guidance filter, ECCV 2014. A Gaussian blur, then several joint bilateral "
        "filters of the picture itself, each guided by the last result: edges that the blur still shows come back "
        "sharp. HDR: as fbl, code values go on above white and nothing is clipped."
    ),
    inputs=(Port("image", "color", "The picture to smooth."),),
    outputs=(Port("image", "color", "The smoothed picture."),),
    params=(
        Param.float(
            "sigma_s",
            2.0,
            min=0,
            max=200,
            soft=(0, 6),
            unit="px",
            label="Scale",
            help="Detail up to about this size goes, however strong it is; 0 changes nothing.",
        ),
        Param.float(
            "sigma_r",
            15.0,
            min=0,
            max=1e6,
            above=True,
            soft=(1, 100),
            unit="code values",
            label="Colour range",
            help="Difference of colour that still counts as alike: higher loses more edges.",
        ),
        Param.int(
            "iterations", 3, min=0, max=100, soft=(1, 6), help="How many times edges are restored; 0 is the blur alone."
        ),
        WORKING_SCALE,
        SPACE,
    ),
    run=run_rolling_guidance,
    region=within(_rolling_guidance_halo, "image"),
)


def run_blur(context: Context, image: Image, *, sigma: float) -> Image:
    return image.with_pixels(filters.blur(image.pixels, sigma=sigma))


def _blur_halo(params: Mapping[str, Any]) -> int:
    return halo.blur(params["sigma"])


BLUR = Node(
    type="blur",
    version=1,
    label="Blur",
    category="utility",
    help="Gaussian blur.",
    doc="Works on premultiplied RGBA; the border is repeated.",
    inputs=(Port("image", "color|mono|matte", "What to blur."),),
    outputs=(Port("image", "=image", "The blurred image."),),
    params=(
        Param.float(
            "sigma", 1.0, min=0, max=500, soft=(0, 20), unit="px", help="Standard deviation; 0 changes nothing."
        ),
    ),
    run=run_blur,
    region=within(_blur_halo, "image"),
)
