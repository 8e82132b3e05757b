"""Turns the curves of graph files into F-curves and back: a graph's curve is linear between whole frames.

What Blender can do beyond straight lines (Bézier and other interpolation, extrapolation, modifiers, keys between
frames) is baked: one key a frame, where the curve is not straight.
"""

from __future__ import annotations

import math
from typing import Any

import bpy

from flowabs_nodes.graph.format import FRAME

from . import fcurves
from .numbers import as_float32, is_number, shortest

LAST_FRAME = 2**24  # whole frames beyond it have no float32 of their own
MOST_BAKED = 100_000  # frames: Blender's timeline ends at 1,048,574

Keys = list[tuple[int, float]]


def keys_of_file(value: Any) -> Keys | None:
    """Return the keys of ``{"curve": ...}`` as an F-curve holds them, in order; None for all that cannot be one."""
    curve = value.get("curve") if isinstance(value, dict) and len(value) == 1 else None
    if not isinstance(curve, dict) or not curve:
        return None
    if not all(FRAME.fullmatch(frame) and abs(int(frame)) <= LAST_FRAME for frame in curve):
        return None
    if not all(is_number(number) for number in curve.values()):
        return None
    return sorted((int(frame), as_float32(number)) for frame, number in curve.items())


def write_curve(tree: bpy.types.NodeTree, path: str, value: Any) -> None:
    """Animate a property of the tree as ``{"curve": ...}`` says; anything else animates nothing."""
    keys = keys_of_file(value)
    if keys is not None:
        fcurves.make(tree, path, keys)


def read_curve(tree: bpy.types.NodeTree, path: str, written: Any, *, whole: bool) -> dict[str, Any] | None:
    """Return ``{"curve": ...}`` of an animated property, None of any other.

    ``written`` is what the file said, which is returned as it was if the F-curve still says the same. ``whole`` is for
    a property of whole numbers.
    """
    curve = fcurves.find(tree, path)
    if curve is None:
        return None
    keys = _keys(curve)
    if keys == keys_of_file(written):
        return written
    return {"curve": {str(frame): math.floor(value + 0.5) if whole else shortest(value) for frame, value in keys}}


def _keys(curve: bpy.types.FCurve) -> Keys:
    """Return the keys of an F-curve between which it is straight, baked where it is not."""
    points = [(point.co[0], point.co[1], point.interpolation) for point in curve.keyframe_points]
    first, last = math.floor(points[0][0]), math.ceil(points[-1][0])
    if len(curve.modifiers) or (curve.extrapolation != "CONSTANT" and len(points) > 1):
        scene = bpy.context.scene
        return _baked(curve, min(first, scene.frame_start), max(last, scene.frame_end))
    if any(frame != round(frame) for frame, _, _ in points):
        return _baked(curve, first, last)
    keys: Keys = []
    for here, after in zip(points, [*points[1:], None], strict=True):
        frame = int(here[0])
        keys.append((frame, here[1]))
        if after is not None:
            keys += _between(curve, here, frame, int(after[0]))
    return keys


def _between(curve: bpy.types.FCurve, key: tuple[float, float, str], frame: int, next_frame: int) -> Keys:
    """Return what stands between a key and the next one: nothing where the curve is straight."""
    if key[2] == "LINEAR":
        return []
    if key[2] == "CONSTANT":
        return [(next_frame - 1, key[1])] if next_frame - 1 > frame else []
    return _baked(curve, frame + 1, next_frame - 1)


def _baked(curve: bpy.types.FCurve, first: int, last: int) -> Keys:
    """Return the value of an F-curve on each frame, or on every n-th of very many."""
    step = max(1, math.ceil((last - first + 1) / MOST_BAKED))
    return [(frame, as_float32(curve.evaluate(frame))) for frame in range(first, last + 1, step)]
