"""Follows port types through a tree, so that an output "of the type of an input" has the colour of what comes out."""

from __future__ import annotations

from collections.abc import Mapping

import bpy

from flowabs_nodes.port_types import TYPES, widest

from .identifiers import graph_nodes
from .links import End, wiring
from .node_classes import declaration_of
from .sockets import ANY

Known = dict[tuple[str, str], str]


def refresh(tree: bpy.types.NodeTree) -> None:
    """Set the ``kind`` of each output whose type follows inputs, "any" where it is not known."""
    wires = wiring(tree)
    known: Known = {}
    for node in graph_nodes(tree):
        declaration = declaration_of(node)
        for socket in node.outputs if declaration is not None else ():
            if declaration.all_outputs[socket.port].follows:
                _follow((node, socket), wires, known)
                kind = known[node.name, socket.port]
                if socket.kind != kind:
                    socket.kind = kind


def _follow(end: End, wires: Mapping[int, End], known: Known) -> None:
    """Note the port type that comes out of an output, and first those that it depends on; "any" in a circle."""
    stack, entered = [end], set()
    while stack:
        node, output = stack[-1]
        here = (node.name, output.port)
        declaration = declaration_of(node)
        port = declaration.all_outputs.get(output.port) if declaration is not None else None
        if here in known or port is None or not port.follows:
            single = port is not None and len(port.accepts) == 1
            known.setdefault(here, port.accepts[0] if port is not None and single else ANY)
            stack.pop()
            continue
        ends = {socket.port: wires.get(socket.as_pointer()) for socket in node.inputs if socket.port in port.follows}
        before = {name: (each[0].name, each[1].port) for name, each in ends.items() if each is not None}
        missing = [ends[name] for name, key in before.items() if key not in known and key not in entered]
        entered.add(here)
        if missing:
            stack += missing
            continue
        kinds = [(name, known.get(key, ANY)) for name, key in before.items()]
        found = [declaration.all_inputs[name].takes(kind) if kind in TYPES else None for name, kind in kinds]
        known[here] = (widest(found) if found and None not in found else None) or ANY
        stack.pop()
