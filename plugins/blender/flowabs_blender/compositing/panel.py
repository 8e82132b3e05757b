"""The panel of the compositing flow: beside the scene's output, and in the sidebars of the compositor and of graphs."""

from __future__ import annotations

import textwrap

import bpy

from ..identifiers import TREE
from .settings import first_of, second_of

MOST = 4  # problems shown; the console has all


class OfBothScenes:
    """Draws the graph, what can be rendered, and what went wrong; mixed into the panels."""

    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the graph, what can be rendered, and what went wrong."""
        layout, scene = self.layout, context.scene
        layout.template_ID(scene, "flowabs_tree")
        second = second_of(scene)
        if second is None:
            layout.operator("flowabs.set_up_compositing", icon="NODE_COMPOSITING")
            return
        first = first_of(scene)
        if first is not None:
            _draw_half(layout, first, passes=True)
        _draw_half(layout, second, passes=False)
        problems = second.flowabs_compositing.problems.splitlines()
        problems += first.flowabs_compositing.problems.splitlines() if first is not None else []
        letters = int(context.region.width / (8 * context.preferences.system.ui_scale))
        _draw_problems(layout, problems, letters)
        row = layout.row(align=True)
        row.operator("flowabs.set_up_compositing", text="Update", icon="FILE_REFRESH")
        row.operator("flowabs.remove_compositing", text="Remove", icon="X")
        layout.operator("flowabs.other_scene", icon="SCENE_DATA")


def _draw_half(layout: bpy.types.UILayout, scene: bpy.types.Scene, *, passes: bool) -> None:
    """Draw where a half is rendered to, and the buttons that render it."""
    box = layout.box()
    what, icon = ("Passes", "RENDERLAYERS") if passes else ("Composite", "NODE_COMPOSITING")
    box.label(text=f"Render {what}: {scene.name}", icon=icon)
    box.prop(scene.render, "filepath", text="")
    row = box.row(align=True)
    for animation, text, icon in ((False, "Frame", "RENDER_STILL"), (True, "Animation", "RENDER_ANIMATION")):
        button = row.operator("flowabs.render_half", text=text, icon=icon)
        button.passes, button.animation = passes, animation


def _draw_problems(layout: bpy.types.UILayout, problems: list[str], letters: int) -> None:
    for problem in problems[:MOST]:
        column = layout.box().column(align=True)
        for number, line in enumerate(textwrap.wrap(problem, max(letters, 16))):
            column.label(text=line, icon="BLANK1" if number else "ERROR")
    if len(problems) > MOST:
        layout.label(text=f"and {len(problems) - MOST} more: the console has them")


class FLOWABS_PT_compositing(OfBothScenes, bpy.types.Panel):
    """Results of a flowabs graph in the compositor"""

    bl_label = "Flowabs in the Compositor"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "output"


class FLOWABS_PT_compositing_nodes(OfBothScenes, bpy.types.Panel):
    """Results of a flowabs graph in the compositor"""

    bl_label = "In the Compositor"
    bl_space_type = "NODE_EDITOR"
    bl_region_type = "UI"
    bl_category = "Flowabs"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Return whether the editor shows a compositor or a flowabs graph."""
        return context.space_data.tree_type in ("CompositorNodeTree", TREE)


CLASSES = (FLOWABS_PT_compositing, FLOWABS_PT_compositing_nodes)
