"""The node that draws lines from the passes of a render."""

from __future__ import annotations

from typing import Any

from flowabs_nodes import filters
from flowabs_nodes.choices import PROJECTIONS
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node, Param, Port

#: The port type of each output, in the order of the filter's result.
_OUTPUTS = {
    "lines": "matte",
    "outline": "matte",
    "object": "matte",
    "material": "matte",
    "crease": "matte",
    "intersection": "matte",
    "strength": "mono",
    "distance": "mono",
    "flow": "flow",
}


def run_aov_lines(
    context: Context,
    depth: Image | None,
    normal: Image | None,
    id: Image | None,
    coverage: Image | None,
    material: Image | None,
    **params: Any,
) -> dict[str, Image]:
    from flowabs_nodes.filters.passes.affine_depth import View  # what numba compiles is not imported for a declaration

    passes = {"depth": depth, "normal": normal, "id": id, "coverage": coverage, "material": material}
    given = {name: each for name, each in passes.items() if each is not None}
    for name in ("id", "material"):  # what read_id gives in place of ids that a render does not have
        if name in given and len(given) > 1 and not given[name].pixels.any():
            del given[name]
    if "id" not in given:
        given.pop("coverage", None)
    arrays: dict[str, Any] = {
        name: each.pixels if name == "normal" else each.pixels[..., 0] for name, each in given.items()
    }
    wanted = context.wanted or frozenset(_OUTPUTS)
    first = next(iter(given.values()), None)
    view = None if first is None else View(*_camera_axis(first))
    made = filters.aov_lines(**arrays, **params, view=view, outputs=wanted)
    assert first is not None  # without any the filter has said so
    return {name: first.with_pixels(getattr(made, name), _OUTPUTS[name]) for name in _OUTPUTS if name in wanted}


def _camera_axis(image: Image) -> tuple[float, float, int, float]:
    """Return the middle of the display window in pixels of the array, its width, and the aspect of a pixel."""
    data, display = image.data_window, image.display_window
    aspect = image.spec.get_float_attribute("PixelAspectRatio", 1.0)
    x, y = display.x + (display.width - 1) / 2 - data.x, display.y + (display.height - 1) / 2 - data.y
    return x, y, display.width, aspect if aspect > 0 else 1.0


AOV_LINES = Node(
    type="aov_lines",
    version=1,
    label="Lines from passes",
    category="lines",
    help="Draws lines from a render's passes: outlines, objects, materials, creases; steady in motion.",
    doc=(
        "Looks at depth, normals and ids and not at light, so shadows, textures and noise make no lines. At least one "
        "of depth, normal and id is needed; each adds what it shows. Depth: where one surface lies before another, "
        "however steeply it runs away. Ids: wherever two objects meet, also where they touch. Normals: creases. Lines "
        "lie on the near side of their edge; on both of a crease, and where two surfaces touch. Each edge is of one "
        "kind, whose ink is an output of its own: outline (before the background), object (before another surface), "
        "material (within an object), crease, and intersection (two objects that touch). Passes should be without "
        "anti-aliasing or noise of their own."
    ),
    inputs=(
        Port("depth", "depth", "Distance from the camera.", optional=True),
        Port("normal", "normal", "Normals, in any space.", optional=True),
        Port("id", "id", "Ids of objects.", optional=True),
        Port(
            "coverage",
            "mono",
            "Coverage of the ids, of a clean render: where within a pixel an edge is.",
            optional=True,
        ),
        Port("material", "id", "Ids of materials.", optional=True),
    ),
    outputs=(
        Port("lines", "matte", "All lines: 1 is paper, 0 is ink."),
        Port("outline", "matte", "Ink, 1, of edges before the background."),
        Port("object", "matte", "Ink of edges before another surface."),
        Port("material", "matte", "Ink between two materials of an object."),
        Port("crease", "matte", "Ink of creases."),
        Port("intersection", "matte", "Ink where two objects touch."),
        Port("strength", "mono", "Strength of the nearest edge, 0 to 1, within 2 px of it: for etf."),
        Port("distance", "mono", "Pixels to the nearest edge, up to 10, positive on its near side; for ink_lines."),
        Port("flow", "flow", "Edge tangent flow of the passes."),
    ),
    params=(
        Param.float(
            "width", 1.5, min=0.5, max=8, soft=(0.5, 4), unit="px", group="Lines", help="Width of lines, creases aside."
        ),
        Param.float(
            "crease_width", 1.5, min=0.5, max=8, soft=(0.5, 4), unit="px", group="Lines", help="Width of creases."
        ),
        Param.float(
            "sigma_m",
            2.0,
            min=0,
            max=20,
            soft=(0, 5),
            unit="px",
            label="Smoothing along lines",
            group="Lines",
            help="Sigma of the average along an edge, which makes the pixels' staircase smooth.",
        ),
        Param.float(
            "depth_step",
            0.02,
            min=0.0001,
            max=1,
            soft=(0.005, 0.1),
            group="Edges",
            help="Step in depth that makes an edge, as a part of the distance; soft from a quarter of it on.",
        ),
        Param.float(
            "crease_angle",
            30.0,
            min=1,
            max=180,
            soft=(10, 90),
            unit="degrees",
            group="Edges",
            help="Turn of the normals that makes a crease; soft from half of it on.",
        ),
        Param.float(
            "crease_reach",
            1.0,
            min=0.5,
            max=20,
            soft=(0.5, 4),
            unit="px",
            group="Edges",
            help="How far to either side of a crease normals are compared: more finds blunter folds.",
        ),
        Param.float(
            "radius", 5.0, min=0, max=500, soft=(2, 15), unit="px", group="Flow", help="Radius of the flow's kernel."
        ),
        Param.int("iterations", 3, min=0, max=100, soft=(1, 5), group="Flow", help="How often the flow is smoothed."),
        Param.enum("projection", "planar", PROJECTIONS, group="Camera", help="What the numbers of the depth pass are."),
        Param.float(
            "field_of_view",
            40.0,
            min=1,
            max=179,
            soft=(15, 100),
            unit="degrees",
            group="Camera",
            enabled_when={"projection": ("distance",)},
            help="Angle that the picture's width covers.",
        ),
    ),
    run=run_aov_lines,
    one_of=("depth", "normal", "id"),
)
