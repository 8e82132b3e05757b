"""Declares the parameters that several nodes have in common."""

from __future__ import annotations

from flowabs_nodes.choices import SAMPLINGS, SPACES
from flowabs_nodes.nodes.declare import Param

SPACE = Param.enum(
    "space",
    "lab",
    SPACES,
    group="Code values",
    help="Code values the filter sees: CIE Lab (L* x 2.55), or ACEScct, where every stop counts the same (HDR).",
)

GROUND = Param.float(
    "ground",
    1.0,
    min=0,
    max=65504,
    soft=(0, 1),
    group="Code values",
    help="Scene-linear grey seen behind transparent pixels, so that an element's outline counts as an edge.",
)


def sampling(default: str) -> Param:
    """Return the parameter that says how pixels are read along the flow; its default is the node's own."""
    return Param.enum(
        "sampling",
        default,
        SAMPLINGS,
        group="Sampling",
        help="How pixels are read along the flow: bilinear is smoother, nearest is crisper and faster.",
    )
