"""Shows pictures in Image Editors."""

from __future__ import annotations

from collections.abc import Iterator

import bpy


def show(context: bpy.types.Context, datablock: bpy.types.Image) -> bpy.types.SpaceImageEditor | None:
    """Show a picture in the editor that an operator was called from, else in the first that shows no render.

    Returns the editor; None where there is none.
    """
    space = context.space_data
    if space is None or space.type != "IMAGE_EDITOR":
        free = (each for _, each in _open() if each.image is None or each.image.type != "RENDER_RESULT")
        space = next(free, None)
    if space is not None:
        space.image = datablock
    return space


def exchange(before: bpy.types.Image | None, after: bpy.types.Image | None) -> bool:
    """Show a picture in place of another in each editor that shows that one; return whether one did."""
    found = [space for _, space in _open() if before is not None and space.image == before]
    for space in found:
        space.image = after
    return bool(found)


def refresh(datablock: bpy.types.Image) -> None:
    """Draw the editors anew that show a picture."""
    for area, space in _open():
        if space.image == datablock:
            area.tag_redraw()


def _open() -> Iterator[tuple[bpy.types.Area, bpy.types.SpaceImageEditor]]:
    """Yield each Image Editor on the screens; none in the background."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "IMAGE_EDITOR":
                yield area, area.spaces.active
