"""The node that lets one of several images through."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.regions import pixelwise

NAMES = tuple("abcdefghij")


def _needs(params: Mapping[str, Any]) -> tuple[str, ...]:
    return (NAMES[params["which"]],)


def run_switch(context: Context, *, which: int, **images: Image) -> Image:
    return images[NAMES[which]]


SWITCH = Node(
    type="switch",
    version=1,
    label="Switch",
    category="utility",
    help="Lets one of several images through; the others are neither computed nor read.",
    doc=(
        "`which` counts from 0, as in Nuke: 0 is a, 1 is b. A knob can drive it, or a curve. The other branches cost "
        "nothing: their files need not be there, and what changes in them changes no key. Inputs are of one type, or "
        "go where the others go, as a matte where a color goes."
    ),
    inputs=tuple(
        Port(name, "any", f"What comes through where which is {i}.", optional=i > 0) for i, name in enumerate(NAMES)
    ),
    outputs=(Port("image", f"={'|'.join(NAMES)}", "The image that was chosen."),),
    params=(Param.int("which", 0, min=0, max=len(NAMES) - 1, soft=(0, 3), help="The input to let through: 0 is a."),),
    run=run_switch,
    needs=_needs,
    region=pixelwise(*NAMES),
)
