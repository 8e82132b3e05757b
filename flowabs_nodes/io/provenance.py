"""Stamp files with the run that made them: its key and its graph.

A later run reads the key, and knows whether the frame is there already.
"""

from __future__ import annotations

import os
import re

import OpenImageIO as oiio

from flowabs_nodes.errors import ReadError
from flowabs_nodes.io import formats
from flowabs_nodes.io.oiio_error import reason

KEY = "flowabs:key"
GRAPH = "flowabs:graph"

#: A stamp in ImageDescription, for formats that drop attributes they do not know (``Format.stamps``).
_LINE = re.compile(r"^(flowabs:[a-z]+)=(.*)$\n?", re.MULTILINE)


def in_description(description: str, stamps: dict[str, str]) -> str:
    """Return an ImageDescription that also holds the stamps, one a line."""
    lines = [f"{name}={' '.join(text.splitlines())}" for name, text in stamps.items()]
    return "\n".join([*([description] if description else []), *lines])


def without_stamps(spec: oiio.ImageSpec) -> None:
    """Remove the stamps of the run that made a plate from its header."""
    for name in (KEY, GRAPH):
        spec.erase_attribute(name)
    if "flowabs:" in (description := _text(spec, "ImageDescription")):
        spec.attribute("ImageDescription", _LINE.sub("", description).rstrip("\n"))


def stored_key(path: str | os.PathLike[str]) -> str | None:
    """Return the key in a file that ``write`` made; None where it holds none, or cannot be opened."""
    try:
        formats.to_read(path)
    except ReadError:
        return None
    source = oiio.ImageInput.open(os.fspath(path))
    if source is None:
        reason(oiio)
        return None
    try:
        spec = source.spec()
        in_lines = dict(_LINE.findall(_text(spec, "ImageDescription")))
        return _text(spec, KEY) or in_lines.get(KEY)
    finally:
        source.close()


def _text(spec: oiio.ImageSpec, name: str) -> str:
    """Return a text attribute; empty where it is missing, or no UTF-8."""
    try:
        return str(spec.get_string_attribute(name))
    except UnicodeDecodeError:
        return ""
