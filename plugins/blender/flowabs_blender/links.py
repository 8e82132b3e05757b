"""Links sockets as a graph file says, and says in a file's words what is linked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import bpy

from .node_classes import declaration_of
from .node_record import read_record, stored, write_record, written_inputs
from .sockets import add_socket, socket_of

#: The port of the first output of a node that is not installed, whose name is not known.
FIRST = "(first)"


def link_nodes(
    tree: bpy.types.NodeTree, nodes: Mapping[str, bpy.types.Node], bodies: Mapping[str, Any]
) -> dict[str, list[str]]:
    """Link the nodes of a graph file, and return the names of the nodes that each is linked to.

    An input whose link leads nowhere is remembered by its node as "kept".
    """
    sources: dict[str, list[str]] = {}
    for name, node in nodes.items():
        kept = {}
        sources[name] = []
        for port, said in written_inputs({"body": bodies[name]} if isinstance(bodies[name], dict) else {}).items():
            output = _output(nodes, said)
            into = input_of(node, port)
            if output is None or into is None:
                kept[port] = said
            else:
                tree.links.new(output, into)
                sources[name].append(said.partition(".")[0])
        if kept:
            write_record(node, {**read_record(node), "kept": kept})
    return sources


def _output(nodes: Mapping[str, bpy.types.Node], said: Any) -> bpy.types.NodeSocket | None:
    """Return the socket that a link of a file comes from; None where there is none."""
    name, dot, port = said.partition(".") if isinstance(said, str) else ("", "", "")
    node = nodes.get(name)
    if node is None:
        return None
    if declaration_of(node) is not None:
        return socket_of(node.outputs, port) if dot else next(iter(node.outputs), None)
    wanted = port if dot else FIRST
    return socket_of(node.outputs, wanted) or add_socket(node.outputs, wanted, None)


def input_of(node: bpy.types.Node, port: str) -> bpy.types.NodeSocket | None:
    """Return the socket of an input; one of a missing node and a further layer of ``write`` are made for it."""
    socket = socket_of(node.inputs, port)
    declaration = declaration_of(node)
    if socket is None and declaration is None:
        return add_socket(node.inputs, port, None)
    if socket is None and declaration is not None and declaration.extra_inputs is not None:
        return add_socket(node.inputs, port, declaration.extra_inputs, extra=True)
    return socket


#: Where an input is linked to: a node and one of its outputs.
End = tuple[bpy.types.Node, bpy.types.NodeSocket]


def wiring(tree: bpy.types.NodeTree) -> dict[int, End]:
    """Return where each input that is linked is linked to, through reroutes, by the address of its socket.

    Made once for all nodes: Blender looks through all links of a tree each time that a socket is asked for its own.
    """
    direct = {link.to_socket.as_pointer(): (link.from_node, link.from_socket) for link in tree.links}
    found: dict[int, End] = {}
    for address, end in direct.items():
        passed = set()
        while end is not None and end[0].bl_idname == "NodeReroute" and end[0].name not in passed:
            passed.add(end[0].name)
            end = direct.get(end[0].inputs[0].as_pointer())
        if end is not None and end[0].bl_idname != "NodeReroute":
            found[address] = end
    return found


def links_of(node: bpy.types.Node, names: Mapping[str, str], wires: Mapping[int, End]) -> dict[str, Any]:
    """Return the links of a node as a graph file has them, in the order that its file had.

    ``names`` are the graph's names of all nodes by the editor's, ``wires`` the tree's :func:`wiring`.
    """
    record = read_record(node)
    written, kept = written_inputs(record), record.get("kept", {})
    linked = {}
    for socket in node.inputs:
        end = wires.get(socket.as_pointer())
        if end is not None and end[0].name in names:
            linked[socket.port] = _said(end, names, written.get(socket.port))
    result = {port: linked.get(port, kept.get(port)) for port in written if port in linked or port in kept}
    return result | {port: said for port, said in linked.items() if port not in result}


def _said(end: End, names: Mapping[str, str], written: Any) -> str:
    """Return "node" for a node's first output, else "node.output"; the first one in full where the file had it so."""
    node, output = end
    name = names[node.name]
    if output.port == FIRST:
        return name
    known = declaration_of(node) is not None or stored(node, "snapshot") != ""
    first = known and output == node.outputs[0]
    in_full = isinstance(written, str) and "." in written
    return f"{name}.{output.port}" if in_full or not first else name
