"""Draws the menu "Graph" in the header of the node editor: presets, import, export, check."""

from __future__ import annotations

from typing import Any

import bpy

from flowabs_nodes.graph import shipped
from flowabs_nodes.graph.shipped import paper

from .identifiers import TREE


class FLOWABS_MT_presets(bpy.types.Menu):
    """The graphs that come with flowabs"""

    bl_label = "New from Preset"

    def draw(self, context: bpy.types.Context) -> None:
        """List them."""
        for name in shipped():
            self.layout.operator("flowabs.new_from_preset", text=name).preset = name
        if paper():
            self.layout.separator()
            self.layout.menu("FLOWABS_MT_paper")


class FLOWABS_MT_paper(bpy.types.Menu):
    """The graphs of the paper's figures"""

    bl_label = "Figures of the Paper"

    def draw(self, context: bpy.types.Context) -> None:
        """List them."""
        for name in paper():
            self.layout.operator("flowabs.new_from_preset", text=name).preset = name


class FLOWABS_MT_graph(bpy.types.Menu):
    """Read and write graph files"""

    bl_label = "Graph"

    def draw(self, context: bpy.types.Context) -> None:
        """List what can be done with a graph."""
        self.layout.menu("FLOWABS_MT_presets")
        self.layout.operator("flowabs.import_graph", icon="IMPORT")
        self.layout.operator("flowabs.export_graph", icon="EXPORT")
        self.layout.separator()
        self.layout.operator("flowabs.edit_graph", icon="PREFERENCES")
        self.layout.operator("flowabs.check", icon="CHECKMARK")
        self.layout.separator()
        self.layout.operator("flowabs.set_up_compositing", icon="NODE_COMPOSITING")


def draw_graph_menu(self: Any, context: bpy.types.Context) -> None:
    """Draw the menu in the editor's header; appended there."""
    if getattr(context.space_data, "tree_type", "") == TREE:
        self.layout.menu("FLOWABS_MT_graph")


CLASSES = (FLOWABS_MT_paper, FLOWABS_MT_presets, FLOWABS_MT_graph)


def register() -> None:
    """Register the menus, and put the first into the header."""
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.NODE_MT_editor_menus.append(draw_graph_menu)


def unregister() -> None:
    """Take them away again."""
    bpy.types.NODE_MT_editor_menus.remove(draw_graph_menu)
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
