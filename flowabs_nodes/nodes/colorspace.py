"""The node that converts a picture to another scene-linear colour space."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from flowabs_nodes import color
from flowabs_nodes.color.spaces import ColorSpace, convert, known
from flowabs_nodes.comp.buffers import finite
from flowabs_nodes.errors import ArgumentError, ColorError
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.regions import pixelwise

EXPECTED = "the name of a scene-linear colour space, such as ACEScg"
ELSEWHERE = "pictures are scene-linear inside a graph; write.colorspace encodes, read.colorspace decodes"


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
        hint = ELSEWHERE if _is_encoding(name, ocio) else error.hint
        raise ArgumentError(error.message, hint=hint, parameter=parameter) from error


def _is_encoding(name: str, ocio: str | None = None) -> bool:
    """Return True for the name of what is no scene-linear colour: a screen's encoding, a camera's log, data."""
    if known(name) is not None:
        return False
    from flowabs_nodes.color.named import find  # imports OpenColorIO, which known spaces do not need

    try:
        return find(name, ocio).kind != "linear"
    except ColorError:
        return False


def _wrong_name(value: Any) -> str | None:
    """Return what is wrong with the name of a space; None where nothing is, or where the run's config may know it."""
    if not isinstance(value, str):
        return EXPECTED
    return f"{EXPECTED}: {ELSEWHERE}" if value and _is_encoding(value) else None


def _wrong_target(value: Any) -> str | None:
    """Return what is wrong with the name of the space to convert to, which must be one."""
    return _wrong_name(value) or (None if value else EXPECTED)


def _space(name: str, default: str, parse: Callable[[Any], str | None], examples: list[str], help: str) -> Param:
    """Return a parameter that is the name of a scene-linear space, of which the OCIO config may know more."""
    schema = {"description": EXPECTED, "type": "string", "examples": examples}
    return replace(Param.custom(name, default, schema=schema, parse=parse, help=help), colorspace=("",))


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
        _space(
            "from",
            "",
            _wrong_name,
            ["lin_rec709", "lin_ap0_scene"],
            'The space that the numbers are in: "" the picture\'s own, another name takes them as that.',
        ),
        _space(
            "to", "lin_rec709", _wrong_target, ["ACEScg", "lin_rec2020"], "The space to convert to, such as ACEScg."
        ),
    ),
    run=run_colorspace,
    converts=True,
    region=pixelwise("image"),
)
