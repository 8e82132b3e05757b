"""The node that inks lines from passes, each kind with a pen of its own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from flowabs_nodes import filters
from flowabs_nodes.filters import halo
from flowabs_nodes.filters.passes.pens import PENS, WIDEST, Pen
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.regions import within

_MEANING = {
    "outline": "before the background",
    "object": "before another surface",
    "material": "between two materials of an object",
    "crease": "of creases",
    "intersection": "where two objects touch",
}


def run_ink_lines(
    context: Context,
    distance: Image,
    flow: Image | None,
    depth: Image | None,
    *,
    width_by_depth: float,
    reference_depth: float,
    taper: float,
    **kinds: Any,
) -> dict[str, Image]:
    mattes = {kind: kinds[kind].pixels[..., 0] for kind in PENS if kinds[kind] is not None}
    ink = filters.ink_lines(
        distance.pixels[..., 0],
        mattes,
        _pens(kinds),
        None if flow is None else flow.pixels,
        None if depth is None else depth.pixels[..., 0],
        width_by_depth,
        reference_depth,
        taper,
    )
    found = {"image": distance.with_pixels(ink, "color")}
    if "lines" in context.wanted:
        found["lines"] = distance.with_pixels(1 - ink[..., 3], "matte")
    return found


def _pens(params: Mapping[str, Any]) -> dict[str, Pen]:
    return {kind: Pen(*(params[f"{kind}_{part}"] for part in Pen._fields)) for kind in PENS}


def _halo(params: Mapping[str, Any]) -> int:
    widest = WIDEST if params["width_by_depth"] > 0 else max(pen.width for pen in _pens(params).values())
    return halo.ink_lines(widest, params["taper"])


def _params_of_pens() -> Iterator[Param]:
    """Yield width, colour and opacity of each kind of line."""
    for kind, pen in PENS.items():
        lines, group = f"lines {_MEANING[kind]}", kind.capitalize()
        yield Param.float(
            f"{kind}_width",
            pen.width,
            min=0,
            max=WIDEST,
            soft=(0, 4),
            unit="px",
            label="Width",
            group=group,
            help=f"Width of {lines}; 0 draws none.",
        )
        yield Param.color(f"{kind}_color", pen.color, label="Colour", group=group, help=f"Colour of {lines}.")
        yield Param.float(
            f"{kind}_opacity",
            pen.opacity,
            min=0,
            max=1,
            soft=(0, 1),
            label="Opacity",
            group=group,
            help=f"Opacity of {lines}.",
        )


INK_LINES = Node(
    type="ink_lines",
    version=1,
    label="Ink lines from passes",
    category="lines",
    help="Inks lines from passes: each kind of edge with a width, a colour and an opacity of its own.",
    doc=(
        "For what aov_lines makes: where the kinds are, their mattes say, and the distance how wide a line may become, "
        "up to 8 px, whatever the width of the mattes (best 1 to 2 px). Lines lie on the near side of their edge, "
        "creases on both. Outlines lie on top, then the kinds in the order of the inputs. The ink is transparent where "
        "there is none: `merge` lays it over a picture. Its colours are linear Rec. 709, unless the passes come with a "
        "colour space."
    ),
    inputs=(
        *(Port(kind, "matte", f"Lines {_MEANING[kind]}, 1 where they are.", optional=True) for kind in PENS),
        Port("distance", "mono", "Pixels to the nearest edge, positive on its near side."),
        Port("flow", "flow", "The flow along the edges; only taper asks for it.", optional=True),
        Port("depth", "depth", "Distance from the camera; only width by depth asks for it.", optional=True),
    ),
    outputs=(
        Port("image", "color", "The ink alone, premultiplied; alpha is its coverage."),
        Port("lines", "matte", "The drawing: 1 is paper, 0 is ink."),
    ),
    params=(
        *_params_of_pens(),
        Param.float(
            "width_by_depth",
            0.0,
            min=0,
            max=2,
            soft=(0, 1),
            group="All lines",
            help="How far lines become thinner with distance: 0 not at all, 1 as things do. Needs depth.",
        ),
        Param.float(
            "reference_depth",
            10.0,
            min=1e-6,
            max=1e9,
            soft=(1, 100),
            group="All lines",
            help="The depth, in scene units, at which lines have their own width.",
        ),
        Param.float(
            "taper",
            0.0,
            min=0,
            max=2000,
            soft=(0, 30),
            unit="px",
            group="All lines",
            help="Over how many pixels ends of lines thin out; 0 leaves them blunt. Needs flow.",
        ),
    ),
    run=run_ink_lines,
    one_of=tuple(PENS),
    region=within(_halo, *PENS, "distance", "flow", "depth"),
)
