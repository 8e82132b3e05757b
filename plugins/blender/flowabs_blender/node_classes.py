"""Makes a Blender node class of each declared node, and one for nodes whose package is not installed."""

from __future__ import annotations

import json
from typing import Any

import bpy

from flowabs_nodes.nodes import catalogue
from flowabs_nodes.nodes.declare import Node

from . import node_drawing
from .identifiers import MISSING, TREE, graph_nodes, node_id
from .names import clean, unique
from .node_record import read_record, stored, write_record
from .properties import properties
from .sockets import add_socket

#: Properties of every node of a graph, beside those of its parameters.
COMMON: dict[str, tuple[Any, dict[str, Any]]] = {
    "graph_name": (bpy.props.StringProperty, {"name": "Name", "description": "The node's name in the graph file"}),
    "record": (bpy.props.StringProperty, {"description": "What the graph file said of the node, JSON"}),
    "snapshot": (bpy.props.StringProperty, {"description": "The node as it is now, JSON, for when its class is gone"}),
    "problems": (bpy.props.StringProperty, {"description": "What is wrong with the node, JSON"}),
}


class FlowabsNode:
    """Behaves as a node of a graph; mixed into the class of each type. ``declaration`` is None where it is missing."""

    declaration: Node | None = None

    @classmethod
    def poll(cls, tree: bpy.types.NodeTree) -> bool:
        """Return whether the node may stand in a tree."""
        return tree.bl_idname == TREE

    def init(self, context: bpy.types.Context) -> None:
        """Give a new node its sockets, and the name of its type."""
        if self.declaration is None:
            return
        tree = self.id_data
        was_filling, tree.is_filling = tree.is_filling, True  # it is updated with each socket, before that has its port
        for sockets, ports in (
            (self.inputs, self.declaration.all_inputs),
            (self.outputs, self.declaration.all_outputs),
        ):
            for name, port in ports.items():
                add_socket(sockets, name, port)
        tree.is_filling = was_filling
        if not was_filling:
            self.graph_name = self.declaration.type

    def copy(self, node: bpy.types.Node) -> None:
        """Give a copy a name of its own; what the file said of the place and the broken links is the original's."""
        record = read_record(self)
        shared = {key: record[key] for key in ("body", "shown") if key in record}
        others = {stored(each, "graph_name") for each in graph_nodes(self.id_data) if each != self}
        if self.graph_name in others:
            write_record(self, shared)
            self.graph_name = unique(self.graph_name, others)

    def draw_label(self) -> str:
        """Return the text of the title: the node's name, and its type where that says more."""
        title = self.bl_label
        return title if clean(title).lower() == self.graph_name.lower() else f"{self.graph_name} · {title}"

    def draw_buttons(self, context: bpy.types.Context, layout: Any) -> None:
        """Draw what is wrong with the node, then its parameters."""
        node_drawing.draw_problems(self, layout)
        if self.declaration is None:
            node_drawing.draw_missing(self, layout)
        else:
            node_drawing.draw_sections(self, layout, self.declaration)

    def draw_buttons_ext(self, context: bpy.types.Context, layout: Any) -> None:
        """Draw the name and every parameter, for the sidebar."""
        layout.prop(self, "graph_name")
        if self.declaration is not None:
            node_drawing.draw_all(self, layout, self.declaration)


def _renamed(node: bpy.types.Node, context: bpy.types.Context) -> None:
    """Make a name that somebody typed one that a graph file allows; a file's own name stays, and check says so."""
    if node.id_data.is_filling:
        return
    if node.graph_name != read_record(node).get("name"):
        others = {stored(each, "graph_name") for each in graph_nodes(node.id_data) if each != node}
        name = unique(clean(node.graph_name), others)
        if name != node.graph_name:
            node.graph_name = name  # comes here again
            return
    node.name = node.graph_name
    node.id_data.update()


def _common() -> dict[str, Any]:
    made = {name: kind(**said) for name, (kind, said) in COMMON.items()}
    made["graph_name"] = COMMON["graph_name"][0](**COMMON["graph_name"][1], update=_renamed)
    return made


def classes() -> list[type]:
    """Return the class of each installed node, and the one of nodes that are not installed."""
    missing = {
        "__annotations__": _common(),
        "__doc__": "A node whose package is not installed here, or is older than the graph; it is kept as it is",
        "bl_idname": MISSING,
        "bl_label": "Not installed",
        "bl_icon": "ERROR",
    }
    return [*map(_node_class, catalogue().values()), type(MISSING, (FlowabsNode, bpy.types.Node), missing)]


def _node_class(declaration: Node) -> type:
    unfolded = node_drawing.unfolded_at_first(declaration)
    sections = {
        node_drawing.section_switch(number): bpy.props.BoolProperty(
            name=section, default=section in unfolded, options=set(), description="Show these parameters"
        )
        for number, section in enumerate(declaration.sections())
    }
    content = {
        "__annotations__": {**_common(), **sections, **properties(declaration.all_params)},
        "__doc__": declaration.help,
        "bl_idname": node_id(declaration.type),
        "bl_label": declaration.label,
        "bl_description": declaration.help,
        "bl_width_default": 220.0,
        "bl_width_min": 140.0,
        "bl_width_max": 500.0,
        "declaration": declaration,
    }
    return type(node_id(declaration.type), (FlowabsNode, bpy.types.Node), content)


def declaration_of(node: bpy.types.Node) -> Node | None:
    """Return the declaration of an editor's node; None where its package is not installed."""
    return getattr(node, "declaration", None)


def body_before(node: bpy.types.Node) -> dict[str, Any]:
    """Return what a node without a class is in a graph file: as it last was with its class, else as the file had it."""
    snapshot = stored(node, "snapshot")
    if snapshot and node.bl_idname != MISSING:
        return json.loads(snapshot)
    return read_record(node).get("body", {})
