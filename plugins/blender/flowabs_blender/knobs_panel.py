"""Draws the sidebar of the node editor: the graph's knobs as sliders, what is wrong, the parameters of a node."""

from __future__ import annotations

import json
import textwrap
from typing import Any

import bpy

from . import knob_watch, knobs
from .knobs import is_ours

LINE = 44  # letters in a sidebar's usual width


def wrapped(text: str) -> list[str]:
    """Return a text as lines that fit into a sidebar."""
    return textwrap.wrap(text.strip(), LINE)


class InSidebar:
    """Puts a panel into the sidebar's tab of flowabs; mixed into the panels."""

    bl_space_type = "NODE_EDITOR"
    bl_region_type = "UI"
    bl_category = "Flowabs"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Return whether the editor shows a flowabs graph."""
        return is_ours(getattr(context.space_data, "edit_tree", None))


class FLOWABS_PT_knobs(InSidebar, bpy.types.Panel):
    """The knobs that the graph offers"""

    bl_label = "Knobs"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw each knob as a slider, by section."""
        tree = context.space_data.edit_tree
        if context.scene.flowabs_tree != tree:
            self.layout.operator("flowabs.use_in_scene", icon="SCENE_DATA")
        draw_knobs(self.layout, tree)


def draw_knobs(layout: Any, tree: bpy.types.NodeTree) -> None:
    """Draw each knob of a tree as a slider, by section."""
    knob_watch.ask_after_move(tree)
    sections: dict[str, list[Any]] = {}
    for knob in tree.knobs:
        sections.setdefault(str(knobs.declaration(knob).get("group", "")), []).append(knob)
    if not sections:
        layout.label(text="This graph has no knobs")
    for section, members in sections.items():
        box = layout.box() if section else layout.column()
        if section:
            box.label(text=section)
        for knob in members:
            _draw_knob(box, tree, knob)


def _draw_knob(layout: Any, tree: bpy.types.NodeTree, knob: Any) -> None:
    row = layout.row(align=True)
    row.active = knob.enabled
    if knob.key:
        row.prop(tree, knobs.path(knob), text=knobs.label(knob), slider=True)
    else:
        row.label(text=f"{knob.name}: wrong in the graph file", icon="ERROR")
    row.operator("flowabs.edit_knob", text="", icon="PREFERENCES").knob = knob.name


class FLOWABS_PT_problems(InSidebar, bpy.types.Panel):
    """What is wrong with the graph"""

    bl_label = "Problems"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        """Write out every problem, each under the name of its node."""
        tree = context.space_data.edit_tree
        owners = [("", tree.problems)]
        owners += [(node.graph_name, node.problems) for node in tree.nodes if getattr(node, "problems", "")]
        found = [(name, problem) for name, text in owners if text for problem in json.loads(text)]
        if not found:
            self.layout.label(text="None", icon="CHECKMARK")
        for name, problem in found:
            box = self.layout.box()
            box.label(text=name or "The graph", icon="INFO" if problem["warning"] else "ERROR")
            for line in problem["long"].splitlines()[1:]:
                for part in wrapped(line):
                    box.label(text=part)
        self.layout.operator("flowabs.check")
        self.layout.operator("flowabs.forget_unknown")


class FLOWABS_PT_parameters(InSidebar, bpy.types.Panel):
    """Every parameter of the active node"""

    bl_label = "Parameters"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Return whether a node of a graph is active."""
        return super().poll(context) and hasattr(context.active_node, "graph_name")

    def draw(self, context: bpy.types.Context) -> None:
        """Draw them by section, each with the button that has a knob drive it."""
        context.active_node.draw_buttons_ext(context, self.layout)


CLASSES = (FLOWABS_PT_knobs, FLOWABS_PT_parameters, FLOWABS_PT_problems)
