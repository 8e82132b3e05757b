"""The operator that switches a graph's live preview on and off."""

from __future__ import annotations

import bpy

from . import fill_datablock, preview
from .node_operators import OfTree, shown_tree


class FLOWABS_OT_preview(OfTree, bpy.types.Operator):
    """Show the result while sliders move, in the Image Editor"""

    bl_idname = "flowabs.preview"
    bl_label = "Live preview"

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Switch the preview on, on the picture in the Image Editor or the chosen one; or off."""
        tree = shown_tree(context)
        if preview.preview_of(tree) is not None:
            preview.switch(tree, on=False)
            return {"FINISHED"}
        space = context.space_data
        if space is not None and space.type == "IMAGE_EDITOR" and space.image is not None:
            tree.run_settings.image = fill_datablock.plate_of(space.image)
        if tree.run_settings.image is None:
            self.report({"ERROR"}, "no picture is chosen: open one, or choose it in the sidebar")
            return {"CANCELLED"}
        preview.switch(tree, on=True)
        return {"FINISHED"}


CLASSES = (FLOWABS_OT_preview,)
