"""Nodes that bring files into a graph: plates, and AOVs as they are."""

from __future__ import annotations

from typing import Any

from flowabs_nodes.file_choices import ALPHAS, MISSING, NONFINITE
from flowabs_nodes.image import Image
from flowabs_nodes.io import formats
from flowabs_nodes.nodes.declare import Context, Node, Param, Port

MISSING_PARAM = Param.enum(
    "missing",
    "error",
    MISSING,
    # What is read instead of a missing frame is in the key by its content.
    in_key=False,
    label="Missing frames",
    group="Sequence",
    help="A frame that is not there: an error, the last one before it, the nearest, black, or no frame at all.",
)


def layer_param(help: str) -> Param:
    """Return the parameter that names a layer of a file."""
    return Param.string("layer", "", group="Layer", help=help)


def _part_problem(value: Any) -> str | None:
    if isinstance(value, str) or (isinstance(value, int) and not isinstance(value, bool) and value >= 0):
        return None
    return "the name of a part, or its number from 0"


def part_param(help: str) -> Param:
    """Return the parameter that names a part of a file."""
    schema = {
        "description": "the name of a part, or its number from 0",
        "anyOf": [{"type": "string"}, {"type": "integer", "minimum": 0}],
    }
    return Param.custom("part", "", schema=schema, parse=_part_problem, group="Layer", help=help)


def run_read(
    context: Context,
    *,
    file: str,
    layer: str,
    part: str | int,
    colorspace: str,
    alpha: str,
    nonfinite: str,
    missing: str = "error",
) -> Image:
    from flowabs_nodes.io.read import read_image

    return read_image(
        file,
        layer=layer,
        part=part,
        colorspace=colorspace,
        alpha=alpha,
        nonfinite=nonfinite,
        settings=context.services,
        note=context.note,
        warn=context.warn,
    )


READ = Node(
    type="read",
    version=1,
    label="Read",
    category="io",
    help=f"A plate from {formats.listed(formats.ALL)}: scene-linear, premultiplied colour.",
    inputs=(),
    outputs=(Port("image", "color", "R, G, B and, where the file has it, A; a grey plate is colour with R = G = B."),),
    params=(
        Param.file(
            "file", role="input", pictures=True, help="File or sequence: plate.exr, plate.####.exr, plate.%04d.exr."
        ),
        layer_param('Layer: "" is the plain R, G, B, A; else its name, a pass (albedo), view layer or eye (right).'),
        part_param(
            'Part of a multi-part EXR, by name or number: "" is rgba, beauty or Combined, else the first with R, G, B.'
        ),
        Param.string(
            "colorspace",
            "auto",
            colorspace=("", "auto"),
            label="Colour space",
            group="Pixels",
            help="Colour space of the file: any OCIO name. auto: its tag, profile, chromaticities, or lin_rec709.",
        ),
        Param.enum(
            "alpha",
            "auto",
            ALPHAS,
            group="Pixels",
            help="What alpha means. auto: premultiplied (PNG: straight), and opaque where it is 0 in every pixel.",
        ),
        Param.enum(
            "nonfinite",
            "repair",
            NONFINITE,
            label="NaN and Inf",
            group="Pixels",
            help="NaN and Inf: repaired from their neighbours, or an error.",
        ),
        MISSING_PARAM,
    ),
    run=run_read,
    doc=" ".join(
        (
            f"Photographs ({formats.listed(formats.DISPLAY_REFERRED, ', ')}) count as sRGB and become linear Rec.709",
            "unless they say otherwise: by an ICC profile (curves and primaries; a table of colours is passed over, as",
            "the log says), and a PNG by cICP, gAMA and cHRM. White of PQ and HLG becomes 1 (203 cd/m2, the code .75).",
            "Of several parts with colour, one named rgba, beauty or Combined goes first; the log says which is read.",
            "A render of Blender's is read from its only view layer, not from what its compositor made of it; of",
            "several view layers, name one: Fg. Of a stereo file the first view is read, else the one that is named:",
            "right, Fg.right, Fg.Combined.right. A pass may go by its last name, DiffCol, whichever version wrote it:",
            "old and new names of Blender's passes are the same; albedo is found under any of its usual names.",
            "Frame -1 may be called -001 or -0001; the log names files whose number has another width than the token.",
            "A file that has the very name, such as icon@2x.png, is that file.",
            *(format.help for format in formats.ALL if format.help),
            "Windows and metadata go along to `write`. An alpha that is ignored, or 0 in every pixel, is written again",
            "as it was, into an EXR.",
        )
    ),
)


def run_read_aov(context: Context, *, file: str, layer: str, part: str | int, missing: str = "error") -> Image:
    from flowabs_nodes.io.read import read_data

    return read_data(file, layer=layer, part=part, settings=context.services, note=context.note, warn=context.warn)


READ_AOV = Node(
    type="read_aov",
    version=1,
    label="Read AOV",
    category="io",
    help="Any AOV: numbers as they are in the file, never colour-converted or clamped.",
    inputs=(),
    outputs=(Port("data", "data", "The layer's channels, under their own names."),),
    params=(
        Param.file("file", role="input", pictures=True, help="File or sequence: render.exr, render.####.exr."),
        layer_param('Layer, or one channel such as Z or N.X: "" is every channel of the part.'),
        part_param('Part of a multi-part EXR, by name or number: "" is the first that has the layer.'),
        MISSING_PARAM,
    ),
    run=run_read_aov,
    doc=(
        "Whole numbers keep their value up to 16777216, the largest that float32 holds exactly with all below it. "
        "Depth, normals, motion and ids have nodes of their own, `read_depth` and so on, which know their names and "
        "their background."
    ),
)
