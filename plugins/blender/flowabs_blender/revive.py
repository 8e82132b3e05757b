"""Makes nodes of missing ones whose package has been installed since."""

from __future__ import annotations

import bpy

from . import layout, node_body
from .identifiers import MISSING, graph_nodes
from .links import FIRST, input_of, wiring
from .node_record import read_record, write_record
from .sockets import socket_of
from .tree_json import names_of


def revive(tree: bpy.types.NodeTree) -> int:
    """Exchange each missing node that is installed now for one of its type, linked as before; return how many."""
    names = names_of(tree)
    missing = [node for node in graph_nodes(tree) if node.bl_idname == MISSING]
    wires = wiring(tree)
    bodies = {node.name: node_body.body_of(node, names, wires) for node in missing}
    back = [node for node in missing if node_body.installed(bodies[node.name]) is not None]
    tree.is_filling = True
    try:
        for node in back:
            _exchange(tree, node, names[node.name], bodies[node.name])
    finally:
        tree.is_filling = False
    if back:
        tree.update()
    return len(back)


def _exchange(tree: bpy.types.NodeTree, node: bpy.types.Node, name: str, body: dict[str, object]) -> None:
    record = read_record(node)
    new = node_body.make_node(tree, name, body, record.get("place", 10**9))
    write_record(new, {**record, **read_record(new), "name": record.get("name", name)})
    for attribute in ("parent", "location", "label", "hide", "use_custom_color", "color", "width"):
        setattr(new, attribute, getattr(node, attribute))
    if record.get("look") == layout.look_of(node):
        write_record(new, {**read_record(new), "look": layout.look_of(new)})
    for link in list(tree.links):
        if link.to_node == node:
            into = input_of(new, link.to_socket.port)
            if into is not None:
                tree.links.new(link.from_socket, into)
        elif link.from_node == node:
            first = next(iter(new.outputs), None)
            output = first if link.from_socket.port == FIRST else socket_of(new.outputs, link.from_socket.port)
            if output is not None:
                tree.links.new(output, link.to_socket)
    tree.nodes.remove(node)
    new.name = name
