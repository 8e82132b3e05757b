"""Nodes that change tone: exposure, a shoulder for highlights, and flattening to a few levels of lightness."""

from __future__ import annotations

import numpy as np

from flowabs_nodes import filters
from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.finishing.deferred import with_operation
from flowabs_nodes.finishing.operations import Quantize
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.regions import pixelwise


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


def run_shoulder(context: Context, image: Image, *, knee: float, headroom: float) -> Image:
    return image.with_pixels(filters.shoulder(image.pixels, knee=knee, headroom=headroom))


SHOULDER = Node(
    type="shoulder",
    version=1,
    label="Shoulder",
    category="tone",
    help="Compresses highlights, hue kept: for what flow and lines look at, so that suns and blown skies draw nothing.",
    doc=(
        "With m the largest of R, G, B, divided by alpha: m' = knee + headroom (1 - exp(-(m - knee) / headroom)) where "
        "m is above the knee, and RGB times m' / m. What is darker stays bit for bit; no highlight passes knee + "
        "headroom. It goes before etf, dog or fdog; flats and the composite take the picture without it, and keep its "
        "light."
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
    ),
    run=run_shoulder,
    region=pixelwise("image"),
)


def run_quantize(context: Context, image: Image, *, levels: int, softness: float) -> Image:
    return with_operation(image, Quantize(levels, softness))


QUANTIZE = Node(
    type="quantize",
    version=1,
    label="Quantize lightness",
    category="tone",
    help="Flattens lightness to a few levels, like poster paint.",
    doc=(
        "The paper's region flattening (section 4.1): L* falls into bins of equal size. A gain on scene-linear RGB, "
        "so that hue stays and no negative value is made; bins go on above white. Between L* 8 and 1 the gain comes "
        "down to 1: what is darker, and noise below zero, stays what it is."
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
    ),
    run=run_quantize,
    region=pixelwise("image"),
)
