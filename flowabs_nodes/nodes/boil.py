"""The node that lets lines boil as much as an artist wants."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flowabs_nodes import filters
from flowabs_nodes.filters import halo
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.regions import within


def run_boil(
    context: Context, lines: Image, flow: Image | None, *, amount: float, hold: int, size: float, seed: int
) -> Image:
    if amount == 0 or flow is None:
        return lines
    data, display = lines.data_window, lines.display_window
    origin = data.x - display.x, data.y - display.y
    moved = filters.boil(lines.pixels[..., 0], flow.pixels, amount, hold, size, seed, context.frame, origin)
    return lines.with_pixels(moved)


def _needs(params: Mapping[str, Any]) -> tuple[str, ...]:
    return ("lines",) if params["amount"] == 0 else ("lines", "flow")


def _moment(params: Mapping[str, Any], frame: int) -> int | None:
    return None if params["amount"] == 0 else (frame - 1) // params["hold"]


def _halo(params: Mapping[str, Any]) -> int:
    return halo.boil(params["amount"])


BOIL = Node(
    type="boil",
    version=1,
    label="Boil",
    category="lines",
    help="Draws lines anew every few frames, each time a little elsewhere, as a hand does.",
    doc=(
        "For drawings that are steadier than an artist's. Ink moves across its strokes, by a smooth field of chance, a "
        "new one every `hold` frames: 2 is animation on twos. The field depends on the frame's number and the place in "
        "the picture alone, so that frames may be made in any order, on any machine. With amount 0 nothing changes, "
        "and the flow is not computed."
    ),
    inputs=(
        Port("lines", "matte", "The drawing: 1 is paper, 0 is ink."),
        Port("flow", "flow", "The flow that the lines follow."),
    ),
    outputs=(Port("lines", "=lines", "The drawing, displaced."),),
    params=(
        Param.float(
            "amount", 0.0, min=0, max=100, soft=(0, 4), unit="px", help="How far ink is displaced at most; 0 is off."
        ),
        Param.int(
            "hold", 2, min=1, max=10_000, soft=(1, 4), unit="frames", help="For how many frames a drawing stays."
        ),
        Param.float(
            "size",
            40.0,
            min=1,
            max=10_000,
            soft=(10, 100),
            unit="px",
            help="How far apart displacements know nothing of each other: small is nervous, large is calm.",
        ),
        Param.int(
            "seed", 1, min=0, max=2**31 - 1, soft=(0, 100), help="Which displacements; the same seed gives the same."
        ),
    ),
    run=run_boil,
    over="lines",
    needs=_needs,
    moment=_moment,
    region=within(_halo, "lines", "flow"),
)
