"""Makes small nodes and graphs for the engine's tests, which need no kernel, no file and no graph document."""

from __future__ import annotations

from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np

from flowabs_nodes.graph.reference_size import ReferenceSize
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node, Param, Port

IMAGE = Port("image", "color", "A picture.")


def _add(context: Context, image: Image, *, amount: float) -> Image:
    return image.with_pixels(image.pixels + np.float32(amount))


ADD = Node(
    type="add",
    version=1,
    help="Adds.",
    inputs=(IMAGE,),
    outputs=(Port("image", "=image", "The sum."),),
    params=(Param.float("amount", 1.0, min=-100, max=100, help="How much."),),
    run=_add,
)


def _split(context: Context, image: Image, *, length: float, slope: float | None) -> dict[str, Image]:
    bright = image.pixels.mean(axis=2)
    return {"matte": image.with_pixels(np.clip(bright, 0, 1), "matte"), "mono": image.with_pixels(bright, "mono")}


SPLIT = Node(
    type="split",
    version=1,
    help="Two outputs.",
    inputs=(IMAGE,),
    outputs=(Port("matte", "matte", "Clipped."), Port("mono", "mono", "Brightness.")),
    params=(
        Param.float("length", 2.0, min=0.5, max=100, unit="px", help="A length."),
        Param.float("slope", 4.0, min=0, unit="code values/px", nullable=True, help="Per pixel."),
    ),
    run=_split,
)


def node(name: str, declaration: Node, inputs: Mapping[str, str] | None = None, **params: Any) -> SimpleNamespace:
    """Return a graph's node as the engine sees it."""
    links = {}
    for port, link in (inputs or {}).items():
        source, _, output = link.partition(".")
        links[port] = SimpleNamespace(node=source, output=output or "image")
    return SimpleNamespace(name=name, declaration=declaration, inputs=links, params=params)


def graph(*nodes: SimpleNamespace, reference_size: ReferenceSize | None = None) -> Any:
    """Return a graph as the engine sees it."""
    return SimpleNamespace(
        name="fake",
        reference_size=reference_size,
        nodes={each.name: each for each in nodes},
        values=lambda frame: {each.name: each.declaration.defaults() | each.params for each in nodes},
    )


def picture(height: int = 6, width: int = 8, alpha: bool = False, seed: int = 1) -> Image:
    """Return noise in 0..1, with windows, metadata and perhaps alpha of its own."""
    rng = np.random.default_rng(seed)
    image = Image.from_array(rng.random((height, width, 4 if alpha else 3)))
    spec = image.spec
    spec.x, spec.y = 3, -2
    spec.full_x, spec.full_y, spec.full_width, spec.full_height = 0, 0, 32, 24
    spec.attribute("owner", "somebody")
    return Image(image.pixels, spec, "color")
