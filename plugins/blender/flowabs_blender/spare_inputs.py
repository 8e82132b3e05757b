"""Shows as many inputs of a node with very many, such as ``switch``, as are linked, and one more."""

from __future__ import annotations

import bpy

from .identifiers import graph_nodes
from .node_classes import declaration_of

FEW = 4  # optional inputs that a node always shows


def refresh(tree: bpy.types.NodeTree) -> None:
    """Hide the inputs beyond the first free one after the last that is linked."""
    for node in graph_nodes(tree):
        declaration = declaration_of(node)
        if declaration is None or sum(port.optional for port in declaration.inputs) <= FEW:
            continue
        linked = [i for i, socket in enumerate(node.inputs) if socket.is_linked]
        shown = max(1 + max(linked, default=-1), 1)
        for i, socket in enumerate(node.inputs):
            port = declaration.all_inputs.get(socket.port)
            hidden = i > shown and port is not None and port.optional
            if socket.hide != hidden:
                socket.hide = hidden
