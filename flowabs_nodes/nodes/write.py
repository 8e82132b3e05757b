"""The node that hands a frame over to be saved."""

from __future__ import annotations

import math
from typing import Any

from flowabs_nodes.file_choices import COMPRESSIONS, DATA_TYPES
from flowabs_nodes.image import Image
from flowabs_nodes.io import formats
from flowabs_nodes.nodes.declare import Context, Node, Param, Port


def _metadata_problem(value: Any) -> str | None:
    from flowabs_nodes.errors import WriteError
    from flowabs_nodes.io.attributes import given, settable

    expected = "an object from attribute names to texts or numbers"
    if not isinstance(value, dict):
        return expected
    for name, content in value.items():
        if not isinstance(name, str) or not settable(name):
            return f"{expected}; {name!r} is not a name that may be set"
        number = isinstance(content, int | float) and not isinstance(content, bool) and math.isfinite(content)
        if not isinstance(content, str) and not number:
            return f"{expected}; {name!r} is {content!r}"
        try:
            given(name, content)
        except WriteError as error:
            return error.message.removeprefix("metadata ")
    return None


def run_write(
    context: Context,
    image: Image,
    *,
    file: str,
    data_type: str,
    compression: str,
    keep_layers: str,
    colorspace: str,
    metadata: dict[str, str | float],
    display: str,
    view: str,
    **layers: Image,
) -> dict[str, Any]:
    """Return the picture, ready to save, as ``picture``; the engine saves it to ``file``."""
    from flowabs_nodes.io.output_image import build_picture

    if not keep_layers.strip(", "):
        _tell_layers_left_out(context, file, image, layers)
    picture = build_picture(
        image,
        layers,
        data_type=data_type,
        compression=compression,
        keep_layers=keep_layers,
        colorspace=colorspace,
        metadata=metadata,
        settings=context.services,
        display=display,
        view=view,
        warn=context.warn,
    )
    return {"picture": picture}


def _tell_layers_left_out(context: Context, file: str, image: Image, layers: dict[str, Image]) -> None:
    """Note which layers of the plate an EXR will not have, and how to keep them."""
    from flowabs_nodes.io.passthrough import layers_left_out

    format = formats.by_extension(file)
    left_out = layers_left_out(image, layers, context.services) if format is not None and format.layers else ()
    if left_out:
        shown = ", ".join(left_out[:6]) + (f" and {len(left_out) - 6} more" if len(left_out) > 6 else "")
        keep = f"--set {context.node}.keep_layers='*'"
        context.note(f"the plate's other layers are left out: {shown} ({keep} keeps all)")


WRITE = Node(
    type="write",
    version=1,
    label="Write",
    category="io",
    help=f"Writes a frame as {formats.listed(formats.WRITABLE)}: whole, or not at all.",
    inputs=(Port("image", "any", "The picture. A mono or matte is written as R = G = B."),),
    outputs=(),
    extra_inputs=Port("layer", "any", "A further layer of an EXR, named as the input."),
    params=(
        Param.file(
            "file", role="output", help="File or sequence to write: out.####.exr; .exr, .png, .tif say the format."
        ),
        Param.enum(
            "data_type",
            "auto",
            DATA_TYPES,
            group="Encoding",
            help="auto: the plate's, else half; flow layers float. PNG: uint8, or uint16 as the plate. TIFF: uint16.",
        ),
        Param.enum(
            "compression",
            "auto",
            COMPRESSIONS,
            group="Encoding",
            help="Of an EXR. auto: the plate's if it is lossless, else zip.",
        ),
        Param.string(
            "keep_layers",
            "",
            group="Header",
            help='The plate\'s other layers to keep, bit for bit: "" none, "*" all, or names with commas.',
        ),
        Param.string(
            "colorspace",
            "plate",
            colorspace=("plate",),
            label="Colour space",
            group="Encoding",
            help="plate: the plate's own; sRGB in a PNG or TIFF of a scene-linear plate; or any OCIO name.",
        ),
        Param.string(
            "display",
            "",
            examples=("default", "sRGB - Display"),
            of_config="display",
            later=True,
            group="Encoding",
            help="Display of the OCIO config to write colours for; default: its first. Implies a view.",
        ),
        Param.string(
            "view",
            "",
            examples=("default", "Raw"),
            of_config="view",
            later=True,
            group="Encoding",
            help="View of the display; default: its first. Both empty: no view, colours are as colorspace says.",
        ),
        Param.custom(
            "metadata",
            {},
            schema={
                "description": "an object from attribute names to texts or numbers",
                "type": "object",
                "additionalProperties": {"type": ["string", "number"]},
            },
            parse=_metadata_problem,
            group="Header",
            help="Attributes to set, by name: texts or numbers. Standard ones get their EXR type.",
        ),
    ),
    run=run_write,
    doc=(
        "Everything that the plate's header says stays, windows, timecode and chromaticities included. Further inputs "
        "become layers: `n` is written as n.R, n.G, n.B[, n.A] (color), n.Y (mono, matte), n.x, n.y (flow), n.Z "
        "(depth), n.X, n.Y, n.Z (normal), n.X, n.Y, n.Z, n.W (motion), n.id (id) or n.<last part of its name> (data). "
        "Depth, normals and motion are always 32-bit floats and ids 32-bit whole numbers, bit for bit, whatever "
        "data_type says. What a header says of colours, views and ACES containers stays only where it is still true. "
        "Standard attributes in `metadata` get their EXR type: framesPerSecond 23.976, timeCode 01:00:00:00. "
        "PNG and TIFF hold the image alone, on the display window, encoded for the screen, with an ICC profile where "
        "that is not sRGB. "
        'With `view` "default" a PNG is what a viewer with the same OCIO config shows: colours, not premultiplied, go '
        "through the view, and the file says what the display's codes are (sRGB, cICP or an ICC profile). Mattes and "
        "mono stay as they are. An EXR may have a view too, but others take its codes for light: a warning says so. "
        "Compressions dwaa, dwab, b44 and b44a change the picture each time it is saved."
    ),
)
