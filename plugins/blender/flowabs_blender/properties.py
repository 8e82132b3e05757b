"""Makes a Blender property of each parameter, and moves values between the properties and graph files.

A value of a graph file may have no exact form as a property (0.1, null, numbers over 2^31, a word of a later version).
Whoever fills a node therefore remembers :func:`value_of` beside the file's value, and takes the file's value again as
long as the property has not moved (``node_record``).
"""

from __future__ import annotations

import json
import math
from typing import Any

import bpy

from flowabs_nodes.graph.overrides import parse_setting
from flowabs_nodes.nodes.describe import rule
from flowabs_nodes.nodes.param import Param

from .numbers import as_float32, just_above, shortest, within_int

AUTOMATIC = "auto_"

#: Lets a path begin with "//", the folder of the .blend; older versions always do.
RELATIVE_PATHS = {"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (4, 5, 0) else set()


def property_name(param: Param) -> str:
    """Return the name of a parameter's property, which no attribute of Blender's nodes has."""
    return "p_" + param.name


def properties(params: dict[str, Param]) -> dict[str, Any]:
    """Return the properties of a node class by name: one for each parameter, and a switch where it may be null."""
    made = {property_name(param): _property(param) for param in params.values()}
    for param in params.values():
        if param.nullable:
            made[AUTOMATIC + param.name] = bpy.props.BoolProperty(
                name="Auto",
                description=f"{param.label} is left to the filter (null in the graph file)",
                default=param.default is None,
                options=set(),
                update=_changed,
            )
    return made


def _changed(node: bpy.types.Node, context: bpy.types.Context) -> None:
    node.id_data.update()


def _property(param: Param) -> Any:
    said: dict[str, Any] = {
        "name": param.label,
        "description": f"{param.help} ({rule(param)})",
        "options": {"ANIMATABLE"} if param.animatable else set(),
        "update": _changed,
    }
    match param.kind:
        case "float":
            return bpy.props.FloatProperty(**said, **_float_range(param))
        case "int":
            return bpy.props.IntProperty(**said, **_int_range(param))
        case "bool":
            return bpy.props.BoolProperty(**said, default=bool(param.default))
        case "enum":
            return bpy.props.EnumProperty(**said, items=_items(param), default=param.default)
        case "color":
            default = tuple(param.default or (0.0, 0.0, 0.0))
            return bpy.props.FloatVectorProperty(**said, default=default, size=3, subtype="COLOR")
        case "file":
            said["options"] = RELATIVE_PATHS
            return bpy.props.StringProperty(**said, subtype="FILE_PATH")
        case _:
            return bpy.props.StringProperty(**said, default=_text(param, param.default))


def _items(param: Param) -> list[tuple[str, str, str]]:
    meanings = param.choice_meanings
    return [(word, label, meanings.get(word, "")) for word, label in param.choice_labels.items()]


def _float_range(param: Param) -> dict[str, Any]:
    lowest = None if param.min is None else just_above(param.min) if param.above else float(param.min)
    default = param.default if param.default is not None else param.soft[0] if param.soft else param.min or 0.0
    range_of = {"min": lowest, "max": param.max, "default": default, **_soft(param)}
    steps = {"precision": 3, "step": 10, "subtype": "PIXEL" if param.unit == "px" else "NONE"}
    return {key: float(value) for key, value in range_of.items() if value is not None} | steps


def _int_range(param: Param) -> dict[str, Any]:
    range_of = {"min": param.min, "max": param.max, "default": param.default or 0, **_soft(param)}
    return {key: within_int(value) for key, value in range_of.items() if value is not None}


def _soft(param: Param) -> dict[str, float]:
    return dict(zip(("soft_min", "soft_max"), param.soft, strict=True)) if param.soft else {}


def _text(param: Param, value: Any) -> str:
    """Return a value as a text field shows it: of a custom parameter a text as it is, all others as JSON."""
    if value is None:
        return ""
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def set_value(node: bpy.types.Node, param: Param, value: Any) -> None:
    """Set a parameter's property as near to a file's value as it can be; one of a wrong type leaves it as it is."""
    name = property_name(param)
    if param.nullable:
        setattr(node, AUTOMATIC + param.name, value is None)
    try:
        match param.kind:
            case "float" | "int" if isinstance(value, bool):
                return
            case "float":
                number = as_float32(float(value))
                largest = as_float32(3.4028234e38)
                setattr(node, name, max(-largest, min(largest, number)))
            case "int":
                setattr(node, name, within_int(value))
            case "custom":
                setattr(node, name, _text(param, value))
            case "color":
                setattr(node, name, [float(part) for part in value])
            case _:
                setattr(node, name, value)
    except (TypeError, ValueError, OverflowError):
        return


def value_of(node: bpy.types.Node, param: Param) -> Any:
    """Return where a parameter's property stands, as plain data: floats with all digits of their float32."""
    if param.nullable and getattr(node, AUTOMATIC + param.name):
        return None
    value = getattr(node, property_name(param))
    return list(value) if param.kind == "color" else value


def is_untouched(node: bpy.types.Node, param: Param) -> bool:
    """Return whether a parameter's property stands at the default."""
    if param.nullable and getattr(node, AUTOMATIC + param.name) != (param.default is None):
        return False
    if param.nullable and param.default is None:
        return True
    declared = node.bl_rna.properties[property_name(param)]
    if param.kind == "color":
        return list(getattr(node, property_name(param))) == list(declared.default_array)
    return bool(getattr(node, property_name(param)) == declared.default)


def file_value(node: bpy.types.Node, param: Param) -> Any:
    """Return where a parameter's property stands, as a graph file says it: floats with the fewest digits."""
    value = value_of(node, param)
    match param.kind:
        case "float":
            return None if value is None else _inside(param, shortest(value))
        case "color":
            return [shortest(part) for part in value]
        case "custom":
            return parse_setting(value)
        case "file":
            return bpy.path.abspath(value) if value.startswith("//") else value
        case _:
            return value


def _inside(param: Param, value: float) -> float:
    """Return a float in the parameter's range, which the nearest float32 may leave by its last digit."""
    low = -math.inf if param.min is None else param.min
    high = math.inf if param.max is None else param.max
    return max(low, min(high, value))
