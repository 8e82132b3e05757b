"""Follows port types through a tree, so that an output "of the type of an input" has the colour of what comes out."""

from __future__ import annotations

import bpy

from flowabs_nodes.port_types import TYPES, widest

from .identifiers import graph_nodes
from .links import source
from .node_classes import declaration_of
from .sockets import ANY


def refresh(tree: bpy.types.NodeTree) -> None:
    """Set the ``kind`` of each output whose type follows inputs, "any" where it is not known."""
    known: dict[tuple[str, str], str] = {}
    for node in graph_nodes(tree):
        declaration = declaration_of(node)
        if declaration is None:
            continue
        for socket in node.outputs:
            port = declaration.all_outputs.get(socket.port)
            if port is not None and port.follows:
                kind = _kind(socket, known, set())
                if socket.kind != kind:
                    socket.kind = kind


def _kind(output: bpy.types.NodeSocket, known: dict[tuple[str, str], str], passing: set[tuple[str, str]]) -> str:
    """Return the port type that comes out of a socket; ``passing`` are those on the way, for circles."""
    here = (output.node.name, output.port)
    declaration = declaration_of(output.node)
    port = declaration.all_outputs.get(output.port) if declaration is not None else None
    if port is None or declaration is None or here in passing:
        return ANY
    if not port.follows:
        return port.accepts[0] if len(port.accepts) == 1 else ANY
    if here not in known:
        found = []
        for socket in output.node.inputs:
            before = source(socket) if socket.port in port.follows else None
            if before is not None:
                kind = _kind(before, known, passing | {here})
                found.append(declaration.all_inputs[socket.port].takes(kind) if kind in TYPES else None)
        known[here] = (widest(found) if found and None not in found else None) or ANY
    return known[here]
