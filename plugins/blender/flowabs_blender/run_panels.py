"""Draws what runs a graph: in the sidebars of the node editor and of the Image Editor, in the tab of flowabs."""

from __future__ import annotations

import json
from typing import Any

import bpy

from . import background, fill_datablock, preview
from .knobs import is_ours
from .knobs_panel import InSidebar, draw_knobs, wrapped
from .node_operators import shown_tree


def draw_run(layout: Any, context: bpy.types.Context) -> None:
    """Draw what computes one picture."""
    tree = shown_tree(context)
    said = tree.run_settings
    if _wrong(tree):
        layout.label(text="The graph cannot run: see Problems", icon="ERROR")
    if context.space_data.type == "NODE_EDITOR":
        layout.template_ID(said, "image", open="image.open")
    layout.prop(said, "output", icon="NODE")
    row = layout.row(align=True)
    on = preview.preview_of(tree)
    row.operator(
        "flowabs.preview", text="Preview", depress=on is not None, icon="HIDE_OFF" if on is not None else "HIDE_ON"
    )
    row.prop(said, "scale", text="")
    if on is not None:
        _draw_state(layout, on)
    column = layout.column(align=True)
    column.operator("flowabs.run", icon="PLAY")
    column.operator("flowabs.run_to_file", icon="FILE_TICK")
    column.operator("flowabs.run_on_render", icon="RENDER_RESULT")
    draw_at_work(layout)


def _draw_state(layout: Any, on: preview.Preview) -> None:
    if on.problem:
        column = layout.column(align=True)
        for number, line in enumerate(wrapped(on.problem)):
            column.label(text=line, icon="BLANK1" if number else "ERROR")
    else:
        layout.label(text=f"{on.seconds * 1000:.0f} ms" if on.seconds else "Computing", icon="TIME")


def draw_sequence(layout: Any, context: bpy.types.Context) -> None:
    """Draw what runs over rendered frames."""
    said = shown_tree(context).run_settings
    for name in ("frames_in", "frames_out", "frame_range", "existing"):
        row = layout.split(factor=0.3)
        row.label(text=said.bl_rna.properties[name].name)
        row.prop(said, name, text="")
    layout.operator("flowabs.run_sequence", icon="RENDER_ANIMATION")


def draw_at_work(layout: Any) -> None:
    """Draw how far the work in the background is, with a button that ends it."""
    for work in background.at_work():
        row = layout.row(align=True)
        if hasattr(row, "progress"):  # Blender 4
            row.progress(factor=work.progress, text=work.text or "at work")
        else:
            row.label(text=f"{work.progress:.0%} {work.text}")
        row.operator("flowabs.cancel", text="", icon="X")


def _wrong(tree: bpy.types.NodeTree) -> bool:
    """Return whether the graph has problems that are no warnings."""
    texts = [tree.problems, *(getattr(node, "problems", "") for node in tree.nodes)]
    return any(not problem["warning"] for text in texts if text for problem in json.loads(text))


class InImageEditor:
    """Puts a panel into the Image Editor's tab of flowabs; mixed into the panels."""

    bl_space_type = "IMAGE_EDITOR"
    bl_region_type = "UI"
    bl_category = "Flowabs"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Return whether the scene has a graph."""
        return is_ours(shown_tree(context))


class FLOWABS_PT_run(InSidebar, bpy.types.Panel):
    """Runs the graph"""

    bl_label = "Run"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the picture, the output, the preview, the buttons."""
        draw_run(self.layout, context)


class FLOWABS_PT_sequence(InSidebar, bpy.types.Panel):
    """Runs the graph over rendered frames"""

    bl_label = "Frames"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the paths and the button."""
        draw_sequence(self.layout, context)


class FLOWABS_PT_image_graph(bpy.types.Panel):
    """The scene's graph"""

    bl_label = "Graph"
    bl_space_type = "IMAGE_EDITOR"
    bl_region_type = "UI"
    bl_category = "Flowabs"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw which graph is the scene's, and the presets where there is none."""
        self.layout.template_ID(context.scene, "flowabs_tree")
        if context.scene.flowabs_tree is None:
            self.layout.menu("FLOWABS_MT_presets")


class FLOWABS_PT_image_run(InImageEditor, bpy.types.Panel):
    """Runs the scene's graph on the picture that is shown"""

    bl_label = "Run"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the output, the preview, the buttons."""
        image = context.space_data.image
        plate = fill_datablock.plate_of(image) if image is not None else None
        if plate is not None:
            self.layout.label(text=plate.name, icon="IMAGE_DATA")
        draw_run(self.layout, context)


class FLOWABS_PT_image_knobs(InImageEditor, bpy.types.Panel):
    """The knobs of the scene's graph"""

    bl_label = "Knobs"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw each knob as a slider, by section."""
        draw_knobs(self.layout, shown_tree(context))


class FLOWABS_PT_image_sequence(InImageEditor, bpy.types.Panel):
    """Runs the scene's graph over rendered frames"""

    bl_label = "Frames"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the paths and the button."""
        draw_sequence(self.layout, context)


CLASSES = (
    FLOWABS_PT_run,
    FLOWABS_PT_sequence,
    FLOWABS_PT_image_graph,
    FLOWABS_PT_image_run,
    FLOWABS_PT_image_knobs,
    FLOWABS_PT_image_sequence,
)
