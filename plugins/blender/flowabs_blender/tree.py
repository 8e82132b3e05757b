"""The node tree that holds a flowabs graph: its knobs, and what happens when it changes."""

from __future__ import annotations

import bpy

from . import knob_watch, problems, socket_kinds, spare_inputs, tree_changes
from .identifiers import TREE
from .knobs import FlowabsKnob, is_ours
from .run_settings import FlowabsRunSettings


class FlowabsTree(bpy.types.NodeTree):
    """A flowabs graph: line drawings and flattened colour that follow the picture's flow"""

    bl_idname = TREE
    bl_label = "Flowabs"
    bl_icon = "BRUSH_DATA"

    knobs: bpy.props.CollectionProperty(type=FlowabsKnob)
    run_settings: bpy.props.PointerProperty(type=FlowabsRunSettings)
    record: bpy.props.StringProperty(description="What the graph file said beside nodes and knobs, JSON")
    problems: bpy.props.StringProperty(description="What is wrong with the graph beside its nodes, JSON")
    knob_positions: bpy.props.StringProperty(description="Where the knobs stood at the last update, JSON")
    is_filling: bpy.props.BoolProperty(description="The tree is being made, and not to be looked at")
    is_kept: bpy.props.BoolProperty(description="The tree was given its fake user, which may have been taken since")

    def update(self) -> None:
        """Check the graph after each change; Blender calls this for nodes and links, properties for themselves."""
        if self.is_filling or self.library is not None:  # what is linked from another file stays as it is there
            return
        if not self.is_kept:
            self.use_fake_user = self.is_kept = True  # else a tree that nothing uses is dropped on save
        socket_kinds.refresh(self)
        spare_inputs.refresh(self)
        problems.refresh(self)
        tree_changes.note(self)
        if not bpy.app.background and not bpy.app.timers.is_registered(_mark_all_links):
            bpy.app.timers.register(_mark_all_links, first_interval=0.0)


def _mark_all_links() -> None:
    for tree in filter(is_ours, bpy.data.node_groups):
        problems.mark_links(tree)


CLASSES = (FlowabsKnob, FlowabsRunSettings, FlowabsTree)


def register() -> None:
    """Register the tree, and the scene's pointer to the graph that belongs to it.

    Blender evaluates the keyframes only of trees that a scene points at.
    """
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Scene.flowabs_tree = bpy.props.PointerProperty(
        type=FlowabsTree, name="Flowabs graph", description="The flowabs graph that belongs to the scene"
    )


def unregister() -> None:
    """Take both away again, and what was to be done soon."""
    for soon in (_mark_all_links, knob_watch.update_moved):
        if bpy.app.timers.is_registered(soon):
            bpy.app.timers.unregister(soon)
    del bpy.types.Scene.flowabs_tree
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
