"""What Blender calls when it renders; in its window, from another thread than the interface's: no operators here.

They are there as long as the extension is, whichever file is open, and look at scenes that are set up alone.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy

from flowabs_nodes.errors import FlowabsError

from . import frame, render_region, settings


@bpy.app.handlers.persistent
def forget_problems(scene: bpy.types.Scene, *_: Any) -> None:
    """Begin a render: what went wrong in the last one is forgotten."""
    if settings.composites(scene) or settings.renders_passes(scene):
        scene.flowabs_compositing.problems = ""


@bpy.app.handlers.persistent
def fill_pictures(scene: bpy.types.Scene, *_: Any) -> None:
    """Before each frame of a composite: run the graph on the frame's passes."""
    if settings.composites(scene):
        frame.fill(scene, scene.frame_current)


@bpy.app.handlers.persistent
def finish_passes(scene: bpy.types.Scene, *_: Any) -> None:
    """After each frame of passes was written: give a still the name of its frame, and a region its place."""
    if not settings.renders_passes(scene):
        return
    file = Path(scene.render.frame_path(frame=scene.frame_current))
    still = Path(bpy.path.abspath(scene.render.filepath))  # a still's #### stays as it is
    try:
        if still.exists():
            still.replace(file)
        if scene.render.use_border:
            render_region.place(file, render_region.region_of(scene), *settings.size_of(scene))
    except (FlowabsError, OSError) as error:
        frame.note(scene, f"frame {scene.frame_current}: {error}")


#: What is called when, by the names of bpy.app.handlers.
HANDLERS = {
    "render_init": forget_problems,
    "render_pre": fill_pictures,
    "render_write": finish_passes,
}


def register() -> None:
    """Have Blender call these."""
    for event, handler in HANDLERS.items():
        getattr(bpy.app.handlers, event).append(handler)


def unregister() -> None:
    """Have Blender call them no more, and let go of what was kept for the next frame."""
    for event, handler in HANDLERS.items():
        listed = getattr(bpy.app.handlers, event)
        if handler in listed:
            listed.remove(handler)
    frame.KEPT.close()
