"""Ends all that is at work, previews and runs, when another file is opened and when the extension goes."""

from __future__ import annotations

from typing import Any

import bpy

from . import background, background_operator, preview


@bpy.app.handlers.persistent
def end_work(*_: Any) -> None:
    """End all work: what it is about is gone."""
    preview.close_all()
    background.end_all()


def register() -> None:
    """Have Blender call this before it opens another file."""
    bpy.app.handlers.load_pre.append(end_work)


def unregister() -> None:
    """Take that away again, and end all work."""
    if end_work in bpy.app.handlers.load_pre:
        bpy.app.handlers.load_pre.remove(end_work)
    end_work()
    background_operator.remove_timers()
