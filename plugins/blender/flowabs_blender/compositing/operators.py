"""The operators of the compositing flow: set it up, render its two halves, take it away."""

from __future__ import annotations

import bpy

from flowabs_nodes.errors import FlowabsError

from ..messages import message
from ..node_operators import OfTree, shown_tree
from .set_up import remove_compositing, set_up_compositing
from .settings import first_of, second_of


class FLOWABS_OT_set_up_compositing(OfTree, bpy.types.Operator):
    """Have this scene render its passes to EXR files, and a second scene composite what the graph makes of them"""

    bl_idname = "flowabs.set_up_compositing"
    bl_label = "Set Up in the Compositor"
    bl_options = {"REGISTER", "UNDO"}

    folder: bpy.props.StringProperty(
        name="Folder",
        description="Where the passes and the composite go; empty: the folder flowabs beside the .blend",
        subtype="DIR_PATH",
    )

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Set both scenes up."""
        try:
            second = set_up_compositing(context.scene, shown_tree(context), folder=self.folder)
        except FlowabsError as error:
            self.report({"ERROR"}, message(error))
            return {"CANCELLED"}
        first = second.flowabs_compositing.source
        self.report({"INFO"}, f"render the passes of {first.name}, then the scene {second.name}")
        if first.render.use_motion_blur and any(layer.use_pass_vector for layer in first.view_layers):
            self.report({"WARNING"}, f"{first.name}: with motion blur Cycles renders no Vector pass")
        return {"FINISHED"}


class FLOWABS_OT_remove_compositing(bpy.types.Operator):
    """Remove the scene that composites, and have the other one render to where it did before"""

    bl_idname = "flowabs.remove_compositing"
    bl_label = "Remove from the Compositor"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Return whether there is anything to remove."""
        return second_of(context.scene) is not None

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Remove it."""
        try:
            remove_compositing(context.scene)
        except FlowabsError as error:
            self.report({"ERROR"}, message(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class FLOWABS_OT_render_half(bpy.types.Operator):
    """Render the passes, or the composite of those that are there"""

    bl_idname = "flowabs.render_half"
    bl_label = "Render Half"

    passes: bpy.props.BoolProperty(name="Passes", description="Those, and not the composite")
    animation: bpy.props.BoolProperty(name="Animation", description="All frames, and not the current one alone")

    @classmethod
    def description(cls, context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        """Return the tooltip."""
        what = "passes" if properties.passes else "composite, from the passes that are there"
        return f"Render the {what}: {'all frames' if properties.animation else 'the current frame'}"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Return whether the two scenes are there."""
        return None not in (first_of(context.scene), second_of(context.scene))

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Begin to render as Blender's own menu does; the passes of a single frame are written, too."""
        first, second = first_of(context.scene), second_of(context.scene)
        scene, other = (first, second) if self.passes else (second, first)
        if scene != context.scene:
            scene.frame_set(other.frame_current)
        still = self.passes and not self.animation
        how = "EXEC_DEFAULT" if bpy.app.background else "INVOKE_DEFAULT"
        try:
            return bpy.ops.render.render(how, scene=scene.name, animation=self.animation, write_still=still)
        except RuntimeError as error:  # Blender's own reports, such as that there is no camera
            self.report({"ERROR"}, str(error).removeprefix("Error: ").strip())
            return {"CANCELLED"}


class FLOWABS_OT_other_scene(bpy.types.Operator):
    """Show the other of the two scenes in this window"""

    bl_idname = "flowabs.other_scene"
    bl_label = "Go to the Other Scene"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Return whether there is a window, and another scene."""
        return context.window is not None and FLOWABS_OT_render_half.poll(context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Show it."""
        first, second = first_of(context.scene), second_of(context.scene)
        frame = context.scene.frame_current
        context.window.scene = second if context.scene == first else first
        context.window.scene.frame_set(frame)
        return {"FINISHED"}


CLASSES = (
    FLOWABS_OT_set_up_compositing,
    FLOWABS_OT_remove_compositing,
    FLOWABS_OT_render_half,
    FLOWABS_OT_other_scene,
)
