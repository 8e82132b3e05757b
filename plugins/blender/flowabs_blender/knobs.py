"""Holds the knobs of a graph as custom properties of its tree: ``tree["line_width"] = 1.5`` turns a knob.

A custom property has a range of its own in each tree, is a slider, takes keyframes, and is a double: numbers of a file
stay as they are. Moving it is what setting the knob's default in the file is.
"""

from __future__ import annotations

import json
import math
from typing import Any

import bpy

from flowabs_nodes.choices import readable
from flowabs_nodes.graph.format import KNOB_TYPES

from . import animation
from .identifiers import TREE
from .numbers import INT_MAX, INT_MIN, is_number, shortest, within_int

LONGEST_KEY = 63  # letters that the name of a custom property may have


class FlowabsKnob(bpy.types.PropertyGroup):
    """A knob that the graph offers"""

    # ``name`` is every property group's own.
    key: bpy.props.StringProperty(description="The custom property that holds the value; empty where none can")
    declared: bpy.props.StringProperty(description="The knob as the graph file has it, JSON")
    shown: bpy.props.StringProperty(description="Where the custom property stood after import, JSON")
    enabled: bpy.props.BoolProperty(default=True, description="Whether turning it changes anything")


def declaration(knob: FlowabsKnob) -> dict[str, Any]:
    """Return a knob as the graph file had it; an empty dict where the file had something else than an object."""
    declared = json.loads(knob.declared)
    return declared if isinstance(declared, dict) else {}


def label(knob: FlowabsKnob) -> str:
    """Return what people read, with the unit: "Line width (px)"."""
    declared = declaration(knob)
    unit = declared.get("unit")
    text = str(declared.get("label") or readable(knob.name))
    return f"{text} ({unit})" if unit else text


def path(knob: FlowabsKnob) -> str:
    """Return the data path of a knob's value, as F-curves and panels want it."""
    return f'["{bpy.utils.escape_identifier(knob.key)}"]'


def fill(tree: bpy.types.NodeTree, interface: Any) -> None:
    """Make the knobs of a graph file's ``interface``, in place of those that the tree has."""
    for knob in list(tree.knobs):
        _forget_value(tree, knob)
    tree.knobs.clear()
    for name, declared in interface.items() if isinstance(interface, dict) else ():
        add(tree, name, declared)


def add(tree: bpy.types.NodeTree, name: str, declared: Any) -> FlowabsKnob:
    """Add a knob, declared as in a graph file; a wrong declaration is kept, and has no slider."""
    knob = tree.knobs.add()
    knob.name, knob.declared = name, json.dumps(declared)
    value = _property_value(declared)
    if value is not None:
        taken = {each.key for each in tree.knobs}
        knob.key = next(key for key in _keys(name) if key not in taken and key not in tree)
        tree[knob.key] = value
        _describe(tree, knob, declared)
        animation.write_curve(tree, path(knob), declared["default"])
        knob.shown = json.dumps(value_of(tree, knob))
    return knob


def remove(tree: bpy.types.NodeTree, name: str) -> None:
    """Take a knob away; parameters that it drove are for the caller."""
    index = tree.knobs.find(name)
    _forget_value(tree, tree.knobs[index])
    tree.knobs.remove(index)


def _forget_value(tree: bpy.types.NodeTree, knob: FlowabsKnob) -> None:
    if knob.key:
        animation.fcurves.remove(tree, path(knob))
        if knob.key in tree:
            del tree[knob.key]


def _keys(name: str) -> Any:
    """Return the names that a knob's custom property may have, the likeliest first."""
    stem = name.encode()[:LONGEST_KEY].decode(errors="ignore")
    yield stem
    short = name.encode()[: LONGEST_KEY - 6].decode(errors="ignore")
    yield from (f"{short}_{number}" for number in range(2, 100_000))


def _property_value(declared: Any) -> Any:
    """Return the value of a knob's custom property; None where the declaration is wrong."""
    if not isinstance(declared, dict) or declared.get("type") not in KNOB_TYPES or "default" not in declared:
        return None
    kind, default = declared["type"], declared["default"]
    keys = animation.keys_of_file(default)
    if keys is not None and kind in ("float", "int"):
        default = keys[0][1]
    match kind:
        case "float" if is_number(default):
            return float(default)
        case "int" if is_number(default):
            return within_int(math.floor(default + 0.5))
        case "bool" if isinstance(default, bool):
            return default
        case "string" if isinstance(default, str):
            return default
        case "enum":
            choices = declared.get("choices")
            return default if isinstance(choices, list) and default in choices and isinstance(default, str) else None
        case "color" if isinstance(default, list) and len(default) == 3 and all(map(is_number, default)):
            return [float(part) for part in default]
    return None


def _describe(tree: bpy.types.NodeTree, knob: FlowabsKnob, declared: dict[str, Any]) -> None:
    """Give a knob's custom property its range and help; of an enum, its words where Blender can list them."""
    kind, shown = declared["type"], {"description": str(declared.get("help", ""))}
    if kind in ("float", "int"):
        number = float if kind == "float" else within_int
        for end in ("min", "max"):
            if is_number(declared.get(end)):
                shown[end] = shown[f"soft_{end}"] = number(declared[end])
        shown |= {"step": 0.1, "precision": 3} if kind == "float" else {}
    elif kind == "color":
        shown |= {"subtype": "COLOR", "min": 0.0, "soft_max": 1.0}
        shown["min"] = min(0.0, *declared["default"])
    elif kind == "enum":
        items = [(word, readable(word), "") for word in declared["choices"]]
        tree[knob.key] = declared["choices"].index(declared["default"])
        try:
            tree.id_properties_ui(knob.key).update(items=items, **shown)
        except TypeError:  # before Blender 4.1: a text
            tree[knob.key] = declared["default"]
        else:
            return
    try:
        tree.id_properties_ui(knob.key).update(**shown)
    except (TypeError, ValueError):  # min above max, or a bool before Blender 3.5: no range is better than no knob
        tree.id_properties_ui(knob.key).update(description=shown["description"])


def value_of(tree: bpy.types.NodeTree, knob: FlowabsKnob) -> Any:
    """Return where a knob stands, as plain data."""
    value = tree.get(knob.key)
    declared = declaration(knob)
    match declared.get("type"):
        case "color":
            return list(value) if value is not None else None
        case "bool":
            return bool(value)
        case "enum" if isinstance(value, int):
            choices = declared["choices"]
            return choices[value] if 0 <= value < len(choices) else declared["default"]
    return value


def interface_of(tree: bpy.types.NodeTree) -> dict[str, Any]:
    """Return the knobs as a graph file's ``interface``, each with the default where it stands now."""
    return {knob.name: _declared_now(tree, knob) for knob in tree.knobs}


def _declared_now(tree: bpy.types.NodeTree, knob: FlowabsKnob) -> Any:
    declared = json.loads(knob.declared)
    if not knob.key or knob.key not in tree:
        return declared
    kind, written = declared["type"], declared["default"]
    curve = animation.read_curve(tree, path(knob), written, whole=kind == "int") if kind in ("float", "int") else None
    if curve is not None:
        return {**declared, "default": curve}
    value = value_of(tree, knob)
    was_curve = animation.keys_of_file(written) is not None
    if json.dumps(value) == knob.shown and not was_curve:
        return declared
    return {**declared, "default": _file_value(value, kind)}


def _file_value(value: Any, kind: str) -> Any:
    """Return a knob's value as a graph file says it: a double that is just a float32, with the fewest digits."""
    if kind == "float":
        return shortest(value) if shortest(value) != value and is_float32(value) else value
    if kind == "color":
        return [shortest(part) if is_float32(part) else part for part in value]
    return max(INT_MIN, min(INT_MAX, value)) if kind == "int" else value


def is_float32(value: float) -> bool:
    """Return whether a double has come from a float32, as all that Blender's sliders set has."""
    return animation.as_float32(value) == value


def is_ours(tree: Any) -> bool:
    """Return whether a tree, or None, holds a flowabs graph."""
    return tree is not None and tree.bl_idname == TREE
