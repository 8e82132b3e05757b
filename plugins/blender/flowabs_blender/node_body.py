"""Makes one node of the editor of a node's body in a graph file, and the body of the node."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import bpy

from flowabs_nodes.nodes import catalogue
from flowabs_nodes.nodes.declare import Node
from flowabs_nodes.nodes.param import Param

from . import animation, layout
from .identifiers import MISSING, node_id
from .links import End, links_of
from .node_classes import body_before, declaration_of
from .node_record import drive_in, read_record, write_record, written_params
from .properties import file_value, is_untouched, property_name, set_value, value_of


def make_node(tree: bpy.types.NodeTree, name: str, body: Any, place: int) -> bpy.types.Node:
    """Add a node as a graph file has it; one that is not installed here is kept as a missing one."""
    declaration = installed(body)
    node = tree.nodes.new(MISSING if declaration is None else node_id(declaration.type))
    node.graph_name = name
    node.name = name
    write_record(node, {"name": name, "body": body, "place": place})
    if declaration is None:
        node.width = 220.0
        return node
    shown = {}
    for key, value in written_params({"body": body}).items():
        param = declaration.all_params.get(key)
        if param is None or drive_in(value) is not None:
            continue
        keys = animation.keys_of_file(value) if param.animatable else None
        if keys is not None:
            set_value(node, param, keys[0][1])
            animation.write_curve(tree, path(node, param), value)
        else:
            set_value(node, param, value)
            shown[key] = value_of(node, param)
    write_record(node, {**read_record(node), "shown": shown})
    return node


def installed(body: Any) -> Node | None:
    """Return the declaration that a body names, in its version; None where it is not installed."""
    written = body.get("type") if isinstance(body, dict) else None
    declaration = catalogue().get(written.partition("@")[0]) if isinstance(written, str) else None
    return declaration if declaration is not None and declaration.name == written else None


def remember(node: bpy.types.Node) -> None:
    """Remember how a node stands in the editor right after import."""
    write_record(node, {**read_record(node), "look": layout.look_of(node)})


def path(node: bpy.types.Node, param: Param) -> str:
    """Return the data path of a parameter's property in its tree, as F-curves have it."""
    return f'nodes["{bpy.utils.escape_identifier(node.name)}"].{property_name(param)}'


def body_of(node: bpy.types.Node, names: Mapping[str, str], wires: Mapping[int, End]) -> Any:
    """Return a node as a graph file has it; ``names`` and ``wires`` are as for ``links_of``."""
    declaration = declaration_of(node)
    body = body_before(node) if declaration is None else read_record(node).get("body", {"type": declaration.name})
    if not isinstance(body, dict):
        return body
    written = body.get("inputs", {})
    links = links_of(node, names, wires) if isinstance(written, dict) else written
    written_here = body.get("params", {})
    readable = declaration is not None and isinstance(written_here, dict)
    params = params_of(node, declaration) if readable and declaration is not None else written_here
    result = dict(body)
    if declaration is not None and "type" not in body:  # made in the editor
        result = {"type": declaration.name, **body}
    parts = {"inputs": links, "params": params}
    for key, said in parts.items():
        if said or said == body.get(key):
            if key in body or said:
                result[key] = said
        else:
            result.pop(key, None)
    if "inputs" not in body and "params" in body and links:  # inputs stand before parameters
        result["params"] = result.pop("params")
    return result


def params_of(node: bpy.types.Node, declaration: Node) -> dict[str, Any]:
    """Return what a node sets its parameters to: those of the file in its order, then what differs from the default."""
    record = read_record(node)
    written, shown = written_params(record), record.get("shown", {})
    result = {}
    for name, said in written.items():
        param = declaration.all_params.get(name)
        result[name] = said if param is None else _value_now(node, param, said, shown)
    for name, param in declaration.all_params.items():
        if name not in written:
            curve = _curve(node, param, None)
            if curve is not None:
                result[name] = curve
            elif not is_untouched(node, param):
                result[name] = file_value(node, param)
    return result


def _value_now(node: bpy.types.Node, param: Param, said: Any, shown: Mapping[str, Any]) -> Any:
    """Return what a parameter is set to, for which the file said something: just that where nobody has changed it."""
    if drive_in(said) is not None:
        return said
    curve = _curve(node, param, said)
    if curve is not None:
        return curve
    if param.name in shown and shown[param.name] == value_of(node, param):
        return said
    return file_value(node, param)


def _curve(node: bpy.types.Node, param: Param, said: Any) -> dict[str, Any] | None:
    if not param.animatable:
        return None
    return animation.read_curve(node.id_data, path(node, param), said, whole=param.kind == "int")
