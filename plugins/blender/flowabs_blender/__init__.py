"""flowabs in Blender: graphs as node trees. Only Blender imports it; scripts use :func:`run` and ``tree_json``."""

from __future__ import annotations

import bpy

from . import (
    add_menu,
    background_operator,
    compositing,
    driving,
    graph_menu,
    graph_settings,
    import_export,
    knob_operators,
    knobs_panel,
    module_exit,
    node_classes,
    node_operators,
    preview_operator,
    run_operators,
    run_panels,
    sockets,
    tree,
    work_end,
)
from .compositing import remove_compositing, set_up_compositing
from .scripting import run

__all__ = ["register", "remove_compositing", "run", "set_up_compositing", "unregister"]

_classes: list[type] = []  # registered, of nodes and sockets: the catalogue says which there are

OPERATORS_AND_PANELS = (
    *node_operators.CLASSES,
    *import_export.CLASSES,
    *graph_settings.CLASSES,
    *driving.CLASSES,
    *knob_operators.CLASSES,
    *background_operator.CLASSES,
    *run_operators.CLASSES,
    *preview_operator.CLASSES,
    *run_panels.CLASSES,
    *knobs_panel.CLASSES,
)


def register() -> None:
    """Register everything; Blender calls this when the extension is enabled.

    The tree comes last, and goes first: a tree of the open file is updated as soon as Blender knows one of the classes,
    and needs all of them.
    """
    for each in (*sockets.classes(), *node_classes.classes(), *OPERATORS_AND_PANELS):
        bpy.utils.register_class(each)
        _classes.append(each)
    tree.register()
    graph_menu.register()
    add_menu.register()
    work_end.register()
    compositing.register()
    module_exit.register(unregister)


def unregister() -> None:
    """Take everything away again; trees stay in the file as they are."""
    work_end.unregister()
    module_exit.unregister(unregister)
    compositing.unregister()
    add_menu.unregister()
    graph_menu.unregister()
    tree.unregister()
    while _classes:
        bpy.utils.unregister_class(_classes.pop())
