"""Nodes that change tone: exposure, a shoulder for highlights, and flattening to a few levels of lightness."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from flowabs_nodes import filters
from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import halo
from flowabs_nodes.finishing.deferred import with_operation
from flowabs_nodes.finishing.operations import Quantize
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.regions import pixelwise, within


def run_exposure(context: Context, image: Image, *, stops: float) -> Image:
    gain = 2.0**stops

    def brighten(rows: Array, first_row: int) -> None:
        light = rows[..., :3]
        largest = max(float(light.max()), -float(light.min()))
        if largest * gain > float(np.finfo(np.float32).max):
            message = f"stops: +{stops:g} takes the picture's largest light, {largest:.3g}, beyond float32"
            raise ArgumentError(message, parameter="stops")
        light *= np.float32(gain)

    return with_operation(image, brighten, context.node)


EXPOSURE = Node(
    type="exposure",
    version=1,
    label="Exposure",
    category="tone",
    help="Brightens or darkens by stops, in scene-linear light.",
    inputs=(Port("image", "color", "The picture."),),
    outputs=(Port("image", "color", "The picture times 2^stops; alpha as it was."),),
    params=(
        Param.float(
            "stops", 0.0, min=-30, max=30, soft=(-5, 5), unit="stops", help="+1 doubles the light, -1 halves it."
        ),
    ),
    run=run_exposure,
    region=pixelwise("image"),
)


def run_shoulder(context: Context, image: Image, *, knee: float, headroom: float, lift: float) -> Image:
    def compress(rows: Array, first_row: int) -> Array:
        return filters.shoulder(rows, knee=knee, headroom=headroom, lift=lift)

    return with_operation(image, compress, context.node)


SHOULDER = Node(
    type="shoulder",
    version=1,
    label="Shoulder",
    category="tone",
    help="Compresses highlights, hue kept: for what flow and lines look at, so that suns and blown skies draw nothing.",
    doc=(
        "With m the largest of R, G, B, divided by alpha: m' = knee + headroom (1 - exp(-(m - knee) / headroom)) where "
        "m is above the knee, and RGB times m' / m. What is darker stays bit for bit; no highlight passes knee + "
        "headroom. Then lift is added, times alpha. It goes before etf, dog or fdog; flats and the composite take the "
        "picture without it, and keep its light."
    ),
    inputs=(Port("image", "color", "The picture."),),
    outputs=(Port("image", "color", "The picture with compressed highlights; alpha as it was."),),
    params=(
        Param.float("knee", 0.6, min=0, max=65504, soft=(0, 1), help="Light from which on it is compressed."),
        Param.float(
            "headroom",
            0.4,
            min=0,
            max=65504,
            above=True,
            soft=(0.05, 2),
            help="How much light above the knee all highlights share: larger keeps more of their differences.",
        ),
        Param.float(
            "lift",
            0.0,
            min=0,
            max=65504,
            soft=(0, 0.1),
            help="Light that is added to all: under acescct the noise of near-black then counts no more than the rest.",
        ),
    ),
    run=run_shoulder,
    region=pixelwise("image"),
)


def run_quantize(context: Context, image: Image, *, by_gradient: float, gradient_length: float, **steps: Any) -> Image:
    rises = None
    if by_gradient > 0:
        from flowabs_nodes.filters.regions.rise import rise  # what numba compiles is not imported for a declaration

        rises = rise(image.encoded_mono("lab"), gradient_length, unit=1 / 2.55)
    return with_operation(image, Quantize(by_gradient=by_gradient, rises=rises, **steps))


def _quantize_halo(params: Mapping[str, Any]) -> int:
    return halo.quantize(params["by_gradient"], params["gradient_length"])


QUANTIZE = Node(
    type="quantize",
    version=1,
    label="Quantize lightness",
    category="tone",
    help="Flattens lightness to a few levels, like poster paint.",
    doc=(
        "The paper's region flattening (section 4.1): L* falls into bins of equal size. A gain on scene-linear RGB, "
        "so that hue stays and no negative value is made; bins go on above white. Between L* 8 and 1 the gain comes "
        "down to 1: what is darker, and noise below zero, stays what it is. By the gradient (after Winnemoeller et "
        "al. 2006), steps are hard along edges, and where lightness is level or a slow ramp nearly gone."
    ),
    inputs=(Port("image", "color", "The picture, usually smoothed by fbl."),),
    outputs=(Port("image", "color", "The flattened picture."),),
    params=(
        Param.int(
            "levels", 8, min=1, max=1000, soft=(4, 16), help="Bins between black and white; the paper uses 4 to 10."
        ),
        Param.float(
            "softness",
            0.0,
            min=0,
            max=1,
            soft=(0, 1),
            unit="bins",
            help="Width of the step from one level to the next: 0 is hard, 1 a smooth ramp.",
        ),
        Param.float(
            "phase",
            0.0,
            min=0,
            max=1,
            soft=(0, 1),
            unit="bins",
            help="Moves all steps up: where they fall across a face or a wall. 1 is a whole level.",
        ),
        Param.float(
            "chroma",
            1.0,
            min=0,
            max=10,
            soft=(0, 2),
            help="Gain on a* and b*: 0 is grey, 1 leaves colours as they are. Above 1, negative values may be made.",
        ),
        Param.float(
            "by_gradient",
            0.0,
            min=0,
            max=1,
            soft=(0, 1),
            group="By the gradient",
            help="How far steps are hard only where lightness is steep: 1 leaves no bands in a clear sky, 0 bands all.",
        ),
        Param.float(
            "gradient_length",
            1.0,
            min=0,
            max=200,
            above=True,
            soft=(0.5, 4),
            unit="px",
            group="By the gradient",
            help="Gaussian before the gradient, and the length that the rise of lightness is measured over.",
        ),
        Param.float(
            "hard_gradient",
            5.0,
            min=0.001,
            max=1000,
            soft=(1, 10),
            unit="L*",
            group="By the gradient",
            help="Rise of L* over that length from which a step is hard: lower paints soft shading in patches too.",
        ),
    ),
    run=run_quantize,
    region=within(_quantize_halo, "image"),
)
