"""The node that lays one drawing under another one of the same edges."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flowabs_nodes import filters
from flowabs_nodes.filters import halo
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.regions import within


def run_join_lines(context: Context, lines: Image, under: Image, *, gap: float) -> Image:
    return lines.with_pixels(filters.join_lines(lines.pixels[..., 0], under.pixels[..., 0], gap))


def _halo(params: Mapping[str, Any]) -> int:
    return halo.join_lines(params["gap"])


JOIN_LINES = Node(
    type="join_lines",
    version=1,
    label="Join lines",
    category="lines",
    help="Lays one drawing under another: of the lines that both have only those of the upper one are drawn.",
    doc=(
        "For lines from passes, which are exact, and lines from luminance, which also see shadows and texture. Both "
        "draw the same silhouettes, a pixel or two apart: the darker of both (merge, min) doubles them. Here the upper "
        "drawing clears the paper around its ink first."
    ),
    inputs=(
        Port("lines", "matte", "The drawing on top: 1 is paper, 0 is ink."),
        Port("under", "matte", "The drawing that makes way."),
    ),
    outputs=(Port("lines", "=lines", "Both drawings, no ink of the upper one lost."),),
    params=(
        Param.float(
            "gap",
            2.5,
            min=0,
            max=500,
            soft=(0, 8),
            unit="px",
            help="How far the lower drawing makes way for ink of the upper one; 0 gives the darker of both.",
        ),
    ),
    run=run_join_lines,
    over="lines",
    region=within(_halo, "lines", "under"),
)
