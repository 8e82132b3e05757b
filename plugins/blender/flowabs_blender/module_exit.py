"""Lets Python end where Blender is its module: 4.5 hangs if trees, classes or handlers of ours are still there then."""

from __future__ import annotations

import atexit
from collections.abc import Callable

import bpy

from .identifiers import TREE

#: A tree once its class is gone.
_WITHOUT_CLASS = "NodeTreeUndefined"


def register(unregister_all: Callable[[], None]) -> None:
    """Have everything of ours go before Python ends; Blender as a program calls ``unregister`` itself."""
    if getattr(bpy.app, "module", False):
        atexit.unregister(_remove_trees)  # once, however often this is called
        atexit.register(_remove_trees)
        atexit.register(unregister_all)


def unregister(unregister_all: Callable[[], None]) -> None:
    """Leave the trees alone to go, as the classes have gone."""
    atexit.unregister(unregister_all)


def _remove_trees() -> None:
    for tree in [each for each in bpy.data.node_groups if each.bl_idname in (TREE, _WITHOUT_CLASS)]:
        bpy.data.node_groups.remove(tree)
