"""Finds and makes the F-curves of a tree, in layered actions (Blender 4.4 and later) and in the flat ones before."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import bpy


def find(tree: bpy.types.NodeTree, path: str) -> bpy.types.FCurve | None:
    """Return the F-curve that moves a property of the tree; None where there is none, or where it is muted."""
    for curve in _all(tree):
        if curve.data_path == path and not curve.mute and len(curve.keyframe_points):
            return curve
    return None


def make(tree: bpy.types.NodeTree, path: str, keys: Iterable[tuple[float, float]]) -> None:
    """Move a property of the tree along straight lines between keys, each a frame and a value."""
    curve = _channels(tree).new(path, index=0)
    for frame, value in keys:
        point = curve.keyframe_points.insert(frame, value, options={"FAST"})
        point.interpolation = "LINEAR"
    curve.update()


def remove(tree: bpy.types.NodeTree, path: str) -> None:
    """Take the F-curves of a property of the tree away."""
    for curve in [each for each in _all(tree) if each.data_path == path]:
        _channels(tree).remove(curve)


def _all(tree: bpy.types.NodeTree) -> list[bpy.types.FCurve]:
    data = tree.animation_data
    if data is None or data.action is None:
        return []
    if not hasattr(data.action, "layers"):
        return list(data.action.fcurves)
    bags = [strip.channelbag(data.action_slot) for layer in data.action.layers for strip in layer.strips]
    return [curve for bag in bags if bag is not None for curve in bag.fcurves]


def _channels(tree: bpy.types.NodeTree) -> Any:
    """Return the tree's collection of F-curves, with an action made for it where it has none."""
    data = tree.animation_data_create()
    if data.action is None:
        data.action = bpy.data.actions.new(f"{tree.name} curves")
    action = data.action
    if not hasattr(action, "layers"):
        return action.fcurves
    if data.action_slot is None:
        data.action_slot = action.slots.new("NODETREE", "flowabs")
    layer = action.layers[0] if action.layers else action.layers.new("Layer")
    strip = layer.strips[0] if layer.strips else layer.strips.new(type="KEYFRAME")
    return strip.channelbag(data.action_slot, ensure=True).fcurves
