"""Remembers what a graph file said of a node, so that what was not touched goes out as it came in."""

from __future__ import annotations

import json
from typing import Any

import bpy

from flowabs_nodes.nodes.param import Param

#: What is remembered beside each node, as JSON in its property ``record``.
#:
#: "name": the file's name of the node. "body": the node as it stood in the file. "shown": where the properties stood
#: right after import, by parameter. "kept": the inputs whose links lead nowhere in the editor. "look": how the node
#: stood in the editor right after. "place": its place among the nodes. All is ASCII: a text property holds no NUL.
Record = dict[str, Any]


def read_record(node: bpy.types.Node) -> Record:
    """Return what is remembered of a node; an empty dict where it was made in the editor."""
    text = stored(node, "record")
    return json.loads(text) if text else {}


def write_record(node: bpy.types.Node, record: Record) -> None:
    """Remember this of a node."""
    node.record = json.dumps(record)


def stored(node: bpy.types.Node, key: str) -> str:
    """Return a text property of a node, also of one whose class is not registered; "" where it is not set."""
    value = getattr(node, key, None)
    if value is None:  # a node that Blender shows as undefined: its properties are there, under no class
        group = node.bl_system_properties_get() if hasattr(node, "bl_system_properties_get") else node
        value = group.get(key) if group is not None else None
    return value if isinstance(value, str) else ""


def written_params(record: Record) -> dict[str, Any]:
    """Return the parameters that the file set, as it wrote them."""
    params = record.get("body", {}).get("params", {})
    return params if isinstance(params, dict) else {}


def written_inputs(record: Record) -> dict[str, Any]:
    """Return the links of the node as the file wrote them."""
    inputs = record.get("body", {}).get("inputs", {})
    return inputs if isinstance(inputs, dict) else {}


def driven_by(node: bpy.types.Node, param: Param) -> dict[str, Any] | None:
    """Return ``{"from": knob}``, perhaps with "map", of a parameter that a knob drives; None for all others."""
    return drive_in(written_params(read_record(node)).get(param.name))


def drive_in(value: Any) -> dict[str, Any] | None:
    """Return a parameter's value in a file where it is ``{"from": knob}``, perhaps with "map"; None for all others."""
    return value if isinstance(value, dict) and isinstance(value.get("from"), str) else None


def set_written(node: bpy.types.Node, name: str, value: Any) -> None:
    """Remember another value for a parameter, as if the file had said it; None forgets the parameter."""
    record = read_record(node)
    body = record.setdefault("body", {})
    params = dict(written_params(record))
    if value is None:
        params.pop(name, None)
    else:
        params[name] = value
    record.get("shown", {}).pop(name, None)
    body["params"] = params
    write_record(node, record)
