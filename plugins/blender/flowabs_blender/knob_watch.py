"""Says which knobs do something with the others as they stand, also after one of them was turned.

Blender calls nothing of ours when a custom property is moved. The panel, which is drawn again each time, therefore asks
here whether a knob has moved since.
"""

from __future__ import annotations

import json
from typing import Any

import bpy

from flowabs_nodes.engine.knob_states import knob_states
from flowabs_nodes.graph import load

from . import knobs
from .identifiers import TREE


def refresh(tree: bpy.types.NodeTree, graph: dict[str, Any]) -> None:
    """Note which knobs of a valid graph do something, and where all of them stand."""
    loaded = load(graph)
    frame = bpy.context.scene.frame_current if bpy.context.scene is not None else 1
    states = {state.name: state.enabled for state in knob_states(loaded, loaded, frame)}
    for knob in tree.knobs:
        if knob.enabled != states.get(knob.name, True):
            knob.enabled = states.get(knob.name, True)


def positions(tree: bpy.types.NodeTree) -> str:
    """Return where all knobs stand, as one text."""
    return json.dumps([knobs.value_of(tree, knob) for knob in tree.knobs if knob.key])


def ask_after_move(tree: bpy.types.NodeTree) -> None:
    """Have a tree updated soon if a knob has moved since its last update; drawing itself may change nothing."""
    if positions(tree) != tree.knob_positions and not bpy.app.timers.is_registered(update_moved):
        bpy.app.timers.register(update_moved, first_interval=0.05)


def update_moved() -> None:
    """Update every tree whose knobs have moved since its last update."""
    for tree in bpy.data.node_groups:
        if tree.bl_idname == TREE and positions(tree) != tree.knob_positions:
            tree.update()
