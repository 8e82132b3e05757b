"""Makes names that a graph file allows: letters, digits and "_", each once, and never Blender's ".001"."""

from __future__ import annotations

import re
from collections.abc import Collection

from flowabs_nodes.graph.format import LONGEST_NAME

BLENDER_NAME_BYTES = 63  # a node of the editor is called by at most this many


def clean(text: str, fallback: str = "node") -> str:
    """Return the allowed name nearest to what somebody typed: "my_lines" for "my lines.001"."""
    name = re.sub(r"\.\d{3,}$", "", text.strip())
    name = re.sub(r"[^A-Za-z0-9_]+", "_", name).strip("_") if not re.fullmatch(r"[A-Za-z0-9_]+", name) else name
    if not name:
        return fallback
    return (f"_{name}" if name[0].isdigit() else name)[:LONGEST_NAME]


def unique(name: str, taken: Collection[str]) -> str:
    """Return the name, or with the first number from 2 on that makes it one that is not ``taken``: "fdog_2"."""
    if name not in taken:
        return name
    stem = re.sub(r"_\d+$", "", name)
    number = 2
    while (found := f"{stem[: LONGEST_NAME - 1 - len(str(number))]}_{number}") in taken:
        number += 1
    return found
