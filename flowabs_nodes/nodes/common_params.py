"""Parameters that several nodes have in common, declared once."""

from __future__ import annotations

from flowabs_nodes.choices import SAMPLINGS, SPACES
from flowabs_nodes.nodes.declare import Param

SPACE = Param.enum(
    "space",
    "lab",
    SPACES,
    help="Code values the filter sees: CIE Lab (L* x 2.55), or ACEScct, where every stop counts the same (HDR).",
)

GROUND = Param.float(
    "ground",
    1.0,
    min=0,
    max=65504,
    soft=(0, 1),
    help="Scene-linear grey seen behind transparent pixels, so that an element's outline counts as an edge.",
)


def sampling(default: str) -> Param:
    """How the image is read along the curve."""
    return Param.enum(
        "sampling",
        default,
        SAMPLINGS,
        help="How pixels are read along the flow: bilinear is smoother, nearest is crisper and faster.",
    )
