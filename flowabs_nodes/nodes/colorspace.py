"""The node that converts a picture to another scene-linear colour space."""

from __future__ import annotations

from flowabs_nodes import color
from flowabs_nodes.color.spaces import ColorSpace, convert
from flowabs_nodes.comp.buffers import finite
from flowabs_nodes.errors import ArgumentError, ColorError
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.regions import pixelwise


def run_colorspace(context: Context, image: Image, **spaces: str) -> Image:
    ocio = getattr(context.services, "ocio", None)
    source = _linear(spaces["from"], "from", ocio) if spaces["from"] else image.colorspace
    target = _linear(spaces["to"], "to", ocio)
    pixels = image.pixels.copy()
    pixels[..., :3] = convert(image.pixels[..., :3], source, target)
    spec = image.with_pixels(pixels).spec
    return Image(finite(pixels, "colorspace"), spec, "color", colorspace=target, origin=image.origin)


def _linear(name: str, parameter: str, ocio: str | None) -> ColorSpace:
    """Return a scene-linear space by name; ArgumentError for any other name, with where encodings belong."""
    try:
        return color.space(name, ocio)
    except ColorError as error:
        hint = error.hint
        if "not scene-linear" in error.message:
            hint = "pictures are scene-linear inside a graph: write.colorspace encodes, read.colorspace decodes"
        raise ArgumentError(error.message, hint=hint, parameter=parameter) from error


COLORSPACE = Node(
    type="colorspace",
    version=1,
    label="Colour space",
    category="tone",
    help="Converts a picture from one scene-linear colour space to another.",
    doc=(
        "A matrix, white to white by Bradford; neutrals keep their value, alpha stays. The picture is in the new "
        "space from here on, and written so where `write` has colorspace plate. What is not scene-linear, a screen's "
        "sRGB or a camera's log, is refused: `write.colorspace` encodes and `read.colorspace` decodes."
    ),
    inputs=(Port("image", "color", "The picture."),),
    outputs=(Port("image", "color", "The picture in the other space."),),
    params=(
        Param.string(
            "from",
            "",
            examples=("lin_rec709", "lin_ap0_scene"),
            help='The space that the numbers are in: "" the picture\'s own, another name takes them as that.',
        ),
        Param.string(
            "to", "lin_rec709", examples=("ACEScg", "lin_rec2020"), help="The space to convert to, such as ACEScg."
        ),
    ),
    run=run_colorspace,
    converts=True,
    region=pixelwise("image"),
)
