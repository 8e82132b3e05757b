"""Shows pictures in Image Editors."""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from .fill_datablock import MARK


def show(
    context: bpy.types.Context, result: bpy.types.Image, plate: bpy.types.Image | None = None
) -> bpy.types.SpaceImageEditor | None:
    """Show a result in the editor that an operator was called from, else in one that shows its plate, or is free.

    An editor is free that shows nothing, or another result. Returns the editor; None where there is none.
    """
    space = context.space_data
    if space is None or space.type != "IMAGE_EDITOR":
        spaces = [space for _, space in _open()]
        shows_plate = (each for each in spaces if plate is not None and each.image == plate)
        free = (each for each in spaces if each.image is None or MARK in each.image)
        space = next(shows_plate, None) or next(free, None)
    if space is not None:
        space.image = result
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
