"""The node that makes a matte of any channel: for masks."""

from __future__ import annotations

import numpy as np

from flowabs_nodes import color
from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError, nearest
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.regions import pixelwise

LUMINANCE = "luminance"


def _channel(context: Context, image: Image, name: str) -> Array:
    """Return the channel ``name``, (H, W); "" is the alpha, else the luminance of a color image, else the first one.

    Raises ArgumentError, with the nearest name, if the image has no such channel.
    """
    if name == "":
        name = "A" if "A" in image.channels else LUMINANCE if image.type == "color" else image.channels[0]
        if image.type == "data" and len(image.channels) > 1:
            context.note(f"the first of {', '.join(image.channels)} is taken: name one (channel)")
    if name == LUMINANCE and image.type == "color":
        return color.luminance(np.ascontiguousarray(image.pixels[..., :3]), image.colorspace)
    if name not in image.channels:
        known = (*image.channels, LUMINANCE) if image.type == "color" else image.channels
        raise ArgumentError(f"the image has no channel {name!r}", hint=nearest(name, known), parameter="channel")
    return image.pixels[..., image.channels.index(name)]


def run_matte(context: Context, image: Image, *, channel: str, low: float, high: float) -> Image:
    values = _channel(context, image, channel)
    if low == high:
        return image.with_pixels((values >= low).astype(np.float32), "matte")
    return image.with_pixels(np.clip((values - np.float32(low)) / np.float32(high - low), 0, 1), "matte")


MATTE = Node(
    type="matte",
    version=1,
    label="Matte of a channel",
    category="utility",
    help="Makes a matte of one channel: alpha, luminance, depth, or any other.",
    doc=(
        "What a roto shape, a render's alpha or a depth pass needs to serve as the mask of another node. low becomes 0 "
        "and high becomes 1, with a ramp between; low above high turns it inside out."
    ),
    inputs=(Port("image", "color|mono|matte|data|depth|normal|motion|id", "What to take the channel from."),),
    outputs=(Port("matte", "matte", "The channel, 0 to 1."),),
    params=(
        Param.string(
            "channel",
            "",
            examples=("A", "R", LUMINANCE, "Z"),
            help='Name of the channel, or "luminance"; "" is the alpha of a picture that has one, else its luminance.',
        ),
        Param.float("low", 0.0, min=-1e30, max=1e30, soft=(0, 1), label="Black at", help="Value that becomes 0."),
        Param.float("high", 1.0, min=-1e30, max=1e30, soft=(0, 1), label="White at", help="Value that becomes 1."),
    ),
    run=run_matte,
    region=pixelwise("image"),
)
