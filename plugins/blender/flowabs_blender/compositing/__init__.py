"""flowabs in the compositing flow: a scene renders its passes to EXR files, a second one composites the graph's result.

Blender does not let a scene see, in its own composite, what was made of its own render. So there are two: the scene of
the shot, whose render output becomes a multilayer EXR a frame, and one beside it, which renders nothing. Before each of
its frames a handler runs the graph on that frame's EXR and fills the pictures that its compositor reads.
"""

from __future__ import annotations

import bpy

from . import handlers, operators, panel, settings
from .set_up import remove_compositing, set_up_compositing

__all__ = ["register", "remove_compositing", "set_up_compositing", "unregister"]

CLASSES = (*settings.CLASSES, *operators.CLASSES, *panel.CLASSES)


def register() -> None:
    """Register the scene's settings, operators, panel and handlers."""
    for each in CLASSES:
        bpy.utils.register_class(each)
    settings.register()
    handlers.register()


def unregister() -> None:
    """Take all of it away again."""
    handlers.unregister()
    settings.unregister()
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
