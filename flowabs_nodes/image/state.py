"""The state of an image as plain data, which may be pickled: numbers, texts, tuples, dicts, and the array of pixels.

OpenImageIO's ``ImageSpec`` cannot be pickled itself. Plain data is read before anything of its version matters, so that
an image of another version is refused in words.
"""

from __future__ import annotations

from dataclasses import asdict
from html import escape
from typing import Any

import numpy as np
import OpenImageIO as oiio

from flowabs_nodes import __version__
from flowabs_nodes.array_types import Array
from flowabs_nodes.color import ColorSpace
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image.parts import Origin, Parts

FORMAT = 1  # raised whenever what `packed` returns changes

_WINDOWS = (
    *("x", "y", "z", "width", "height", "depth"),
    *("full_x", "full_y", "full_z", "full_width", "full_height", "full_depth"),
    *("tile_width", "tile_height", "tile_depth"),
    *("nchannels", "channelnames", "alpha_channel", "z_channel", "deep"),
)
#: Base type, aggregate, meaning and array length of an OpenImageIO type.
Kind = tuple[str, str, str, int]
#: Name, type and value of an attribute.
Attribute = tuple[str, Kind, Any]
#: The types of attributes that OpenImageIO's Python can set; UCHAR and UINT8 are two names of one.
_SETTABLE = ("INT", "UINT", "FLOAT", "STRING", "UCHAR", "UINT8")


def packed(
    pixels: Array, spec: oiio.ImageSpec, type: str, colorspace: ColorSpace, origin: Origin | None
) -> dict[str, Any]:
    """Return the state of an image: a dict with the ``format`` of the state and the version of flowabs."""
    return {
        "format": FORMAT,
        "flowabs": __version__,
        "pixels": pixels,
        "spec": {name: getattr(spec, name) for name in _WINDOWS},
        "data_types": tuple(map(_type, (spec.format, *spec.channelformats))),
        "attributes": _attributes(spec),
        "type": type,
        "colorspace": (colorspace.name, colorspace.to_xyz),
        "origin": None if origin is None else asdict(origin),
    }


def unpacked(state: Any) -> tuple[Parts, ColorSpace, Origin | None]:
    """Return the parts of the image, its colour space and origin that :func:`packed` made ``state`` of.

    Raises
    ------
    FlowabsError
        other-version, for the state of an image of another version of this package.
    """
    found = state.get("format") if isinstance(state, dict) else None
    if found != FORMAT:
        version = state.get("flowabs", "another version") if isinstance(state, dict) else "another version"
        raise FlowabsError(
            f"an image that flowabs {version} pickled cannot be read by flowabs {__version__}: "
            f"expected format {FORMAT}, found {found}",
            code="other-version",
            hint="use the same version of flowabs on both sides",
        )
    spec = _with_attributes(state["attributes"])
    for name, value in state["spec"].items():
        setattr(spec, name, value)
    spec.format, *channelformats = (_type_desc(*each) for each in state["data_types"])
    spec.channelformats = tuple(channelformats)
    origin = None if state["origin"] is None else Origin(**state["origin"])
    return Parts(state["pixels"], spec, state["type"]), ColorSpace(*state["colorspace"]), origin


def _type(kind: oiio.TypeDesc) -> Kind:
    """Return an OpenImageIO type as names and a length; :func:`_type_desc` makes it again."""
    return kind.basetype.name, kind.aggregate.name, kind.vecsemantics.name, kind.arraylen


def _type_desc(base: str, aggregate: str, meaning: str, length: int) -> oiio.TypeDesc:
    """Return the OpenImageIO type of these names and this length."""
    return oiio.TypeDesc(
        getattr(oiio.BASETYPE, base), getattr(oiio.AGGREGATE, aggregate), getattr(oiio.VECSEMANTICS, meaning), length
    )


def _attributes(spec: oiio.ImageSpec) -> list[Attribute]:
    """Return the name, type and value of each attribute of a header."""
    found = []
    for attribute in spec.extra_attribs:
        try:
            value = attribute.value
        except UnicodeDecodeError:  # OpenImageIO 3.0, where a text is no UTF-8
            continue
        if isinstance(value, np.ndarray):
            value = value.tobytes() if value.dtype == np.uint8 else tuple(value.ravel().tolist())
        if value is not None:
            found.append((attribute.name, _type(attribute.type), value))
    return found


def _with_attributes(attributes: list[Attribute]) -> oiio.ImageSpec:
    """Return a header with these attributes and nothing else.

    What Python cannot set comes from XML: numbers of 8, 16, 32 or 64 bits. Vectors and matrices of such come as numbers
    of float or int: OpenImageIO has no way to make them.
    """
    spec = oiio.ImageSpec()
    others = [each for each in attributes if each[1][0] not in _SETTABLE]
    if others:
        items = (
            f'<attrib name="{escape(name)}" type="{_type_desc(*kind)}">{_text(value)}</attrib>'
            for name, kind, value in others
        )
        spec.from_xml(f'<ImageSpec version="27">{"".join(items)}</ImageSpec>')
    for name, kind, value in attributes:
        if kind[0] in _SETTABLE:
            spec.attribute(name, _type_desc(*kind), value)
        elif spec.getattribute(name) is None:
            whole = all(isinstance(each, int) for each in np.ravel(np.asarray(value, object)))
            spec.attribute(name, _type_desc("INT" if whole else "FLOAT", *kind[1:]), value)
    return spec


def _text(value: Any) -> str:
    """Return a number, or numbers, as OpenImageIO's XML has them."""
    return ", ".join(map(repr, value)) if isinstance(value, tuple | list) else repr(value)
