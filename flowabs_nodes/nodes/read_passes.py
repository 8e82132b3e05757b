"""Nodes that bring the passes of a render into a graph: depth, normals, motion, ids."""

from __future__ import annotations

from typing import Any

import numpy as np

from flowabs_nodes.errors import ReadError
from flowabs_nodes.file_choices import ABSENT, MOTION_CONVENTIONS
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.read import MISSING_PARAM, layer_param, part_param

#: What the nodes of this file have in common.
ABSENT_PARAM = Param.enum(
    "absent",
    "error",
    ABSENT,
    label="Where there is no such pass",
    help="What is read in place of a pass that the file does not have.",
    later=True,
)
FILE = Param.file(
    "file", role="input", pictures=True, help='File or sequence: render.####.exr. "" is the plate\'s own file.'
)
LAYER = layer_param('Layer ("ViewLayer.Depth", "Depth"), view layer, eye, channel or part: "" finds its usual name.')
PART = part_param('Part of a multi-part EXR, by name or number: "" looks through all.')
_COMPARED = (
    "Names are compared without the view layer in front, without VRay, case, spaces and underscores. Where several "
    "layers could be meant, or none, the error lists what the file has. A view layer's name (Fg), an eye's (right) or "
    "both (Fg.right) mean the pass in there, as they mean the picture for `read`; of a stereo file the first eye is "
    "read. A pass in a file of its own may be called anything, R, G, B too: the only layer of a file is taken."
)


def _pass_over(error: ReadError, absent: str, context: Context) -> None:
    """Tell that a pass is not in the file. Raises ``error`` where it says something else, or it must be there."""
    if absent == "error" or error.code != "no-layer":
        raise error
    tell = context.note if absent == "optional" else context.warn
    tell(f"nothing is read: {error.message.partition(' (')[0]}")


def run_read_depth(context: Context, *, file: str, missing: str = "error", **where: Any) -> Image:
    from flowabs_nodes.io.read_passes import read_depth

    return read_depth(file, settings=context.services, note=context.note, warn=context.warn, **where)


READ_DEPTH = Node(
    type="read_depth",
    version=1,
    label="Read depth",
    category="io",
    help="The depth pass of a render, in scene units.",
    inputs=(),
    outputs=(Port("depth", "depth", "Distance from the camera, as it is in the file; 1e10 is the background."),),
    params=(FILE, LAYER, PART, MISSING_PARAM),
    run=run_read_depth,
    doc=(
        "Usual names: Depth (Blender, Karma), Z (OpenEXR, Arnold, RenderMan), zDepth or Z Depth (V-Ray), Pz (Mantra). "
        f"{_COMPARED} Background is what lies at 1e10 or more, Inf, and in a half channel 65504: it becomes 1e10. A "
        "depth that was scaled to 0 to 1, as V-Ray may do, stays so."
    ),
)


def run_read_normal(
    context: Context, *, file: str, missing: str = "error", absent: str = "error", **where: Any
) -> Image:
    from flowabs_nodes.io.read_passes import read_normal, read_nothing

    try:
        return read_normal(file, settings=context.services, note=context.note, warn=context.warn, **where)
    except ReadError as error:
        _pass_over(error, absent, context)
        return read_nothing(file, "normal", settings=context.services)


READ_NORMAL = Node(
    type="read_normal",
    version=1,
    label="Read normals",
    category="io",
    help="The normal pass of a render, in the renderer's own space.",
    inputs=(),
    outputs=(Port("normal", "normal", "X, Y, Z as they are in the file; 0, 0, 0 where there is no surface."),),
    params=(FILE, LAYER, PART, MISSING_PARAM, ABSENT_PARAM),
    run=run_read_normal,
    doc=f"Usual names: Normal (Blender), N (Arnold, Karma), Nn (RenderMan), normals (V-Ray). {_COMPARED}",
)


def run_read_motion(context: Context, *, file: str, missing: str = "error", **where: Any) -> Image:
    from flowabs_nodes.io.read_motion import read_motion

    return read_motion(file, settings=context.services, note=context.note, warn=context.warn, **where)


READ_MOTION = Node(
    type="read_motion",
    version=1,
    label="Read motion",
    category="io",
    help="The motion pass of a render, in pixels: where each pixel was, and where it goes.",
    inputs=(),
    outputs=(
        Port(
            "motion",
            "motion",
            "Blender's convention, y up: X, Y lead to the place on the previous frame, -Z, -W to that on the next.",
        ),
    ),
    params=(
        FILE,
        LAYER,
        PART,
        Param.enum(
            "convention",
            "auto",
            MOTION_CONVENTIONS,
            help="What the file's numbers say. auto: X, Y, Z, W are Blender's, motionBack and backward lead back.",
        ),
        MISSING_PARAM,
    ),
    run=run_read_motion,
    doc=(
        "Usual names: Vector (Blender), motionvector (Arnold, Karma), velocity (V-Ray), motionFore and motionBack "
        f"(RenderMan), forward and backward (Nuke). {_COMPARED} Of a file that knows one way only, the other way is "
        "taken for the opposite. Vectors of 3e5 and more (in a half channel 65504), which Blender writes where there "
        "is no surface, become 0, and so do those of 1e4, 1e4, which stand outside of its render region."
    ),
)


def run_read_id(
    context: Context, *, file: str, missing: str = "error", absent: str = "error", **where: Any
) -> dict[str, Image]:
    from flowabs_nodes.io.read_id import read_id
    from flowabs_nodes.io.read_passes import read_nothing

    try:
        ids, coverage = read_id(file, settings=context.services, note=context.note, warn=context.warn, **where)
    except ReadError as error:
        _pass_over(error, absent, context)
        ids = read_nothing(file, "id", settings=context.services)
        coverage = ids.with_pixels(np.ones(ids.pixels.shape[:2], np.float32), "mono")
    return {"id": ids, "coverage": coverage}


READ_ID = Node(
    type="read_id",
    version=1,
    label="Read ids",
    category="io",
    help="Which object each pixel of a render shows: ids, exact to 32 bits, from a Cryptomatte or an id pass.",
    inputs=(),
    outputs=(
        Port("id", "id", "The id that covers most of the pixel; 0 is the background."),
        Port("coverage", "mono", "The part of the pixel that this id covers, 0 to 1; 1 for an id pass."),
    ),
    params=(FILE, LAYER, PART, MISSING_PARAM, ABSENT_PARAM),
    run=run_read_id,
    doc=(
        "Usual names, the first that is there: CryptoObject (Blender), crypto_object (Arnold), Cryptomatte (V-Ray); ID "
        "(Arnold), id (RenderMan), Object Index (Blender; before 5.0 IndexOB), Object ID, Render ID (V-Ray), primid "
        "(Karma); Material Index or IndexMA (Blender), MtlID (V-Ray); else the file's only Cryptomatte. The layer "
        "cryptomatte, or Fg.cryptomatte, is a Cryptomatte under whatever name; the layer material, or Fg.material, is "
        "CryptoMaterial (Blender), crypto_material (Arnold), or else Material Index, IndexMA, MtlID or Material ID. "
        f"{_COMPARED} In a Cryptomatte the background wins a pixel of which all ids together leave more than the first "
        "has, and the manifest goes along as metadata. An id pass may be stored as uint, float or half."
    ),
)
