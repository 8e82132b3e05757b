"""Names the classes that Blender registers: a saved .blend holds these names, so they never change."""

from __future__ import annotations

import bpy

TREE = "FlowabsTree"
MISSING = "FlowabsMissing"
NODE_PREFIX = "FlowabsNode_"
SOCKET_PREFIX = "FlowabsSocket_"
UNDEFINED = "NodeUndefined"  # what Blender calls a node whose class is not registered


def node_id(type_name: str) -> str:
    """Return the class name of the nodes of a type, such as "FlowabsNode_etf" for "etf"."""
    return NODE_PREFIX + type_name


def socket_id(kind: str) -> str:
    """Return the class name of the sockets of a port type, or of "any"."""
    return SOCKET_PREFIX + kind


def holds_graph_node(node: bpy.types.Node) -> bool:
    """Return whether a node of the editor stands for one of the graph, as frames and reroutes do not."""
    return node.bl_idname.startswith(NODE_PREFIX) or node.bl_idname in (MISSING, UNDEFINED)


def graph_nodes(tree: bpy.types.NodeTree) -> list[bpy.types.Node]:
    """Return the nodes of the editor that stand for nodes of the graph."""
    return [node for node in tree.nodes if holds_graph_node(node)]
