"""Changes what a graph says of itself: its description, and the size of picture that its lengths are meant for."""

from __future__ import annotations

import json
from typing import Any

import bpy

from flowabs_nodes.graph.format import FORMAT

from .node_operators import OfTree, shown_tree

SIDES = [
    ("none", "As written", "Pixel lengths are as written, whatever the picture's size"),
    ("shorter", "Shorter side", "Pixel lengths grow with the picture's shorter side"),
    ("height", "Height", "Pixel lengths grow with the picture's height"),
    ("width", "Width", "Pixel lengths grow with the picture's width"),
    ("diagonal", "Diagonal", "Pixel lengths grow with the picture's diagonal"),
]


def read_head(tree: bpy.types.NodeTree) -> dict[str, Any]:
    """Return what a graph says beside nodes and knobs, as its file has it."""
    return json.loads(tree.record)["head"] if tree.record else {"format": FORMAT}


def write_head(tree: bpy.types.NodeTree, head: dict[str, Any]) -> None:
    """Have a graph say this beside nodes and knobs."""
    record = json.loads(tree.record) if tree.record else {}
    tree.record = json.dumps({**record, "head": head})


class FLOWABS_OT_edit_graph(OfTree, bpy.types.Operator):
    """Change the graph's description and the size of picture that its lengths are meant for"""

    bl_idname = "flowabs.edit_graph"
    bl_label = "Graph Settings"
    bl_options = {"REGISTER", "UNDO"}

    description_text: bpy.props.StringProperty(name="Description")
    side: bpy.props.EnumProperty(name="Lengths for", items=SIDES)
    size: bpy.props.IntProperty(name="Pixels", default=1080, min=1, max=65536)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask, with what the graph says now."""
        head = read_head(shown_tree(context))
        self.description_text = str(head.get("description", ""))
        said = head.get("reference_size", {"height": head["reference_height"]} if "reference_height" in head else {})
        self.side = "none"
        for side, size in said.items() if isinstance(said, dict) else ():
            if side in [each[0] for each in SIDES] and isinstance(size, int | float):
                self.side, self.size = side, int(size)
        return context.window_manager.invoke_props_dialog(self, width=420)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Change what the graph says."""
        tree = shown_tree(context)
        head = read_head(tree)
        before = dict(head)
        said = {"description": self.description_text or None}
        if self.side == "none" or head.get("reference_size", {}).get(self.side) != self.size:
            head.pop("reference_height", None)
            said["reference_size"] = None if self.side == "none" else {self.side: self.size}
        for key, value in said.items():
            head.pop(key, None) if value is None else head.update({key: value})
        last = {key: head.pop(key) for key in ("interface", "nodes", "ui") if key in head}
        if head != {key: before[key] for key in before if key not in last}:
            write_head(tree, {**head, **last})
            tree.update()
        return {"FINISHED"}


CLASSES = (FLOWABS_OT_edit_graph,)
