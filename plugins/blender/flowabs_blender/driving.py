"""Drives a parameter by a knob, straight or through a map, and makes new knobs for it."""

from __future__ import annotations

import json
from typing import Any

import bpy

from flowabs_nodes.graph.knobs import DRIVES
from flowabs_nodes.graph.values import interpolate
from flowabs_nodes.nodes.param import Param

from . import animation, knobs
from .names import clean, unique
from .node_body import path
from .node_classes import declaration_of
from .node_operators import OfTree, shown_tree
from .node_record import driven_by, set_written
from .numbers import is_number
from .properties import file_value, set_value

NEW_KNOB = "+"  # no knob is called so

#: The words of the dialog's list: Blender keeps no reference to them, and they must outlive the call.
_items: dict[str, list[tuple[str, str, str]]] = {}


def drive(node: bpy.types.Node, param: Param, knob: str, points: list[list[float]] | None = None) -> None:
    """Have a knob drive a parameter, through the ``points`` [x, y] of a map where there are any."""
    animation.fcurves.remove(node.id_data, path(node, param))
    set_written(node, param.name, {"from": knob, **({"map": points} if points else {})})


def stop_driving(node: bpy.types.Node, param: Param) -> None:
    """Leave a parameter where its knob has it."""
    said = driven_by(node, param)
    if said is None:
        return
    set_written(node, param.name, None)
    tree = node.id_data
    knob = tree.knobs.get(said["from"])
    if knob is not None:
        value = knobs.value_of(tree, knob)
        if said.get("map") and is_number(value):
            value = interpolate([tuple(point) for point in said["map"]], value)
            value = round(value) if param.kind == "int" else value
        set_value(node, param, value)


def new_knob(node: bpy.types.Node, param: Param) -> str:
    """Make a knob of a parameter, with its range, help and value, that drives it; return the knob's name."""
    tree = node.id_data
    name = unique(clean(f"{node.graph_name}_{param.name}"), {knob.name for knob in tree.knobs})
    declared = knob_for(param, file_value(node, param))
    knobs.add(tree, name, declared)
    drive(node, param, name)
    return name


def knob_for(param: Param, value: Any) -> dict[str, Any]:
    """Return the declaration of a knob for a parameter, as a graph file has it."""
    kind = "string" if param.kind in ("file", "custom") else param.kind
    default = value if value is not None else param.soft[0] if param.soft else 0
    declared: dict[str, Any] = {"type": kind, "default": default, "label": param.label, "help": param.help}
    if param.numeric:
        low, high = param.soft or (param.min, param.max)
        low = min(low, default) if low is not None else None
        high = max(high, default) if high is not None else None
        low = param.soft[0] if param.above and param.soft and low == param.min else low
        ends = {"min": low, "max": high, "unit": param.unit or None}
        declared |= {key: said for key, said in ends.items() if said is not None}
    if kind == "enum":
        declared["choices"] = list(param.choices)
    return declared


def fitting_knobs(tree: bpy.types.NodeTree, param: Param) -> list[str]:
    """Return the names of the knobs that may drive a parameter, some of them only through a map."""
    kinds = {*DRIVES[param.kind], *(("float", "int") if param.numeric else ())}
    return [knob.name for knob in tree.knobs if knobs.declaration(knob).get("type") in kinds]


def _target(self: Any, context: bpy.types.Context) -> tuple[Any, Param | None]:
    tree = shown_tree(context)
    node = tree.nodes.get(self.node) if tree is not None else None
    declaration = declaration_of(node) if node is not None else None
    return node, declaration.all_params.get(self.parameter) if declaration is not None else None


def _choices(self: Any, context: bpy.types.Context) -> list[tuple[str, str, str]]:
    node, param = _target(self, context)
    found = [(NEW_KNOB, "A new knob", "Make a knob with the range of the parameter")]
    if node is not None and param is not None:
        found += [(name, name, "") for name in fitting_knobs(node.id_data, param)]
    return _items.setdefault(json.dumps(found), found)


class FLOWABS_OT_drive(OfTree, bpy.types.Operator):
    """Have a knob of the graph drive this parameter"""

    bl_idname = "flowabs.drive"
    bl_label = "Drive by a knob"
    bl_options = {"REGISTER", "UNDO"}

    node: bpy.props.StringProperty(options={"HIDDEN"})
    parameter: bpy.props.StringProperty(options={"HIDDEN"})
    knob: bpy.props.EnumProperty(name="Knob", items=_choices)
    map: bpy.props.StringProperty(
        name="Map", description="Points [[x, y], ...] from the knob's value to the parameter's; empty: as it is"
    )
    stop: bpy.props.BoolProperty(name="Stop driving", description="Leave the parameter where the knob has it")

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask which knob, and through which map."""
        node, param = _target(self, context)
        said = driven_by(node, param) if param is not None else None
        if said is not None and said["from"] in [item[0] for item in _choices(self, context)]:
            self.knob, self.map = said["from"], json.dumps(said["map"]) if said.get("map") else ""
        return context.window_manager.invoke_props_dialog(self, width=380)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Drive the parameter, or stop."""
        node, param = _target(self, context)
        if param is None:
            self.report({"ERROR"}, f"no parameter {self.parameter!r} of {self.node!r}")
            return {"CANCELLED"}
        try:
            points = json.loads(self.map) if self.map.strip() else None
        except ValueError:
            self.report({"ERROR"}, f"the map is not JSON: {self.map}; write it as [[0, 8], [1, 0.5]]")
            return {"CANCELLED"}
        if self.stop:
            stop_driving(node, param)
        elif self.knob == NEW_KNOB:
            new_knob(node, param)
        else:
            drive(node, param, self.knob, points)
        node.id_data.update()
        return {"FINISHED"}


CLASSES = (FLOWABS_OT_drive,)
