"""The node that draws lines as an artist's pen does."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flowabs_nodes import filters
from flowabs_nodes.filters import halo
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.regions import within


def run_stroke(
    context: Context,
    lines: Image,
    flow: Image,
    response: Image | None,
    *,
    min_length: float,
    taper: float,
    strength: float,
) -> Image:
    if min_length == taper == strength == 0:
        return lines
    forces = None if response is None else response.pixels[..., 0]
    drawing = filters.stroke(lines.pixels[..., 0], flow.pixels, min_length, taper, strength, forces)
    return lines.with_pixels(drawing)


def _stroke_halo(params: Mapping[str, Any]) -> int:
    return halo.stroke(params["min_length"], params["taper"])


STROKE = Node(
    type="stroke",
    version=1,
    label="Stroke",
    category="lines",
    help="Draws lines as an artist's pen does: no short strokes, ends that taper, weak lines thin.",
    doc=(
        "For the drawing of any line node, before composite. The length of a stroke is measured along the flow, over "
        "small gaps too; strokes become narrower as they become shorter or weaker and then are gone, so that none pops "
        "in a moving picture. Nothing becomes darker. With all three at 0 nothing changes."
    ),
    inputs=(
        Port("lines", "matte", "The drawing: 1 is paper, 0 is ink."),
        Port("flow", "flow", "The flow that the lines follow."),
        Port("response", "mono", "The response that the lines come of; only strength asks for it.", optional=True),
    ),
    outputs=(Port("lines", "=lines", "The drawing, no darker than it was."),),
    params=(
        Param.float(
            "min_length",
            0.0,
            min=0,
            max=2000,
            soft=(0, 40),
            unit="px",
            label="Shortest stroke",
            help="A stroke of this length along the flow is half as wide; one of half this length is gone.",
        ),
        Param.float(
            "taper",
            0.0,
            min=0,
            max=2000,
            soft=(0, 30),
            unit="px",
            help="Over how many pixels a stroke grows from a point to its width; 0 leaves ends blunt.",
        ),
        Param.float(
            "strength",
            0.0,
            min=0,
            max=1000,
            soft=(0, 40),
            unit="code values",
            label="Full width at",
            help="Response at which a stroke has its full width, thinner below; 0: all strokes alike. Needs response.",
        ),
    ),
    run=run_stroke,
    over="lines",
    region=within(_stroke_halo, "lines", "flow", "response"),
)
