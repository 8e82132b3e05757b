"""Stamp files with the run that made them: its key, its graph and scale, and a hash of the pixels.

A later run reads the stamp, and knows whether the frame is there already, whether it may replace it, and whether its
pixels are still those that were written.
"""

from __future__ import annotations

import json
import os
import re
from typing import NamedTuple

import OpenImageIO as oiio

from flowabs_nodes.errors import ReadError
from flowabs_nodes.io import formats
from flowabs_nodes.io.oiio_error import reason

KEY = "flowabs:key"
GRAPH = "flowabs:graph"
SCALE = "flowabs:scale"
PIXELS = "flowabs:pixels"

#: A stamp in ImageDescription, for formats that drop attributes they do not know (``Format.stamps``).
_LINE = re.compile(r"^(flowabs:[a-z]+)=(.*)$\n?", re.MULTILINE)


def in_description(description: str, stamps: dict[str, str]) -> str:
    """Return an ImageDescription that also holds the stamps, one a line."""
    lines = [f"{name}={' '.join(text.splitlines())}" for name, text in stamps.items()]
    return "\n".join([*([description] if description else []), *lines])


def without_stamps(spec: oiio.ImageSpec) -> None:
    """Remove the stamps of the run that made a plate from its header."""
    for name in (KEY, GRAPH, SCALE, PIXELS):
        spec.erase_attribute(name)
    if "flowabs:" in (description := _text(spec, "ImageDescription")):
        spec.attribute("ImageDescription", _LINE.sub("", description).rstrip("\n"))


class Stamp(NamedTuple):
    """What a file says of the run that made it.

    Attributes
    ----------
    key
        Names what was computed; "" in a file that no run made.
    graph
        The graph's name, "" where it has none; None where the file does not say.
    scale
        The run's ``scale``; None in files of version 0.2.0, which do not say.
    pixels
        The hash of the pixels (:mod:`flowabs_nodes.io.pixel_hash`); "" in files of version 0.2.0.
    """

    key: str = ""
    graph: str | None = None
    scale: float | None = None
    pixels: str = ""


def stored_stamp(path: str | os.PathLike[str]) -> Stamp | None:
    """Return the stamp in a file, an empty one where it has none; None where its header cannot be read."""
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
        found = {name: _text(spec, name) or in_lines.get(name, "") for name in (KEY, GRAPH, SCALE, PIXELS)}
        return Stamp(found[KEY], _name_in(found[GRAPH]), _number(found[SCALE]), found[PIXELS])
    finally:
        source.close()


def stored_key(path: str | os.PathLike[str]) -> str | None:
    """Return the key in a file that ``write`` made; None where it holds none, or cannot be opened."""
    stamp = stored_stamp(path)
    return stamp.key or None if stamp else None


def _name_in(document: str) -> str | None:
    """Return the name of a graph that is given as JSON; None where that is none."""
    try:
        graph = json.loads(document)
    except (ValueError, RecursionError):
        return None
    name = graph.get("name", "") if isinstance(graph, dict) else None
    return name if isinstance(name, str) else None


def _number(text: str) -> float | None:
    """Return the number that a text says; None where it says none."""
    try:
        return float(text)
    except ValueError:
        return None


def _text(spec: oiio.ImageSpec, name: str) -> str:
    """Return a text attribute; empty where it is missing, or no UTF-8."""
    try:
        return str(spec.get_string_attribute(name))
    except UnicodeDecodeError:
        return ""
