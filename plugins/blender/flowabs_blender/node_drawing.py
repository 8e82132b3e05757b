"""Draws a node: its problems, its parameters by section, and what drives them."""

from __future__ import annotations

import json
import textwrap
from typing import Any

import bpy

from flowabs_nodes.graph.values import interpolate
from flowabs_nodes.nodes.declare import Node
from flowabs_nodes.nodes.param import Param

from . import knobs
from .node_record import drive_in, read_record, written_params
from .numbers import is_number
from .properties import AUTOMATIC, property_name, value_of

LINE = 46  # letters of a problem in a node's usual width


def section_switch(number: int) -> str:
    """Return the name of the property that says whether a node's section is unfolded."""
    return f"unfolded_{number}"


def unfolded_at_first(declaration: Node) -> set[str]:
    """Return the sections that a new node shows: its first one, where only choices stand outside of sections."""
    sections = declaration.sections()
    named = [section for section in sections if section]
    return set(named[:1]) if all(param.kind == "enum" for param in sections.get("", ())) else set()


def draw_problems(node: bpy.types.Node, layout: Any) -> None:
    """Draw each problem of a node as a line, whose tooltip says all of it."""
    for problem in json.loads(node.problems) if node.problems else ():
        row = layout.row()
        row.alert = not problem["warning"]
        icon = "INFO" if problem["warning"] else "ERROR"
        text = textwrap.shorten(problem["short"], LINE, placeholder=" …")
        row.operator("flowabs.explain_problem", text=text, icon=icon, emboss=False).text = problem["long"]


def draw_missing(node: bpy.types.Node, layout: Any) -> None:
    """Draw the type of a node that is not installed, and what the graph sets."""
    body = read_record(node).get("body")
    layout.label(text=str(body.get("type", "no type")) if isinstance(body, dict) else "not a node", icon="QUESTION")
    if not node.problems:
        layout.operator("flowabs.check", text="Installed now: bring it back", icon="FILE_REFRESH")
    for name, value in written_params({"body": body}).items() if isinstance(body, dict) else ():
        layout.label(text=textwrap.shorten(f"{name}: {json.dumps(value)}", LINE, placeholder=" …"))


def draw_sections(node: bpy.types.Node, layout: Any, declaration: Node) -> None:
    """Draw the parameters of a node: those of no section at once, the others folded up until they are asked for."""
    written, values = written_params(read_record(node)), _values(node, declaration)
    sections = declaration.sections()
    for number, (section, params) in enumerate(sections.items()):
        if section and len(sections) > 1:
            switch = section_switch(number)
            unfolded = getattr(node, switch)
            icon = "DISCLOSURE_TRI_DOWN" if unfolded else "DISCLOSURE_TRI_RIGHT"
            heading = layout.row()
            heading.alignment = "LEFT"
            heading.prop(node, switch, icon=icon, emboss=False)
            if not unfolded:
                continue
        _draw_params(node, layout, declaration, params, written, values)
    if declaration.extra_inputs:
        layout.operator("flowabs.add_layer", icon="ADD").node = node.name


def draw_all(node: bpy.types.Node, layout: Any, declaration: Node) -> None:
    """Draw every parameter of a node by section, each with a button to have it driven by a knob."""
    written, values = written_params(read_record(node)), _values(node, declaration)
    for section, params in declaration.sections().items():
        column = layout.column()
        if section:
            column.label(text=section)
        _draw_params(node, column, declaration, params, written, values, drives=True)


def _values(node: bpy.types.Node, declaration: Node) -> dict[str, Any]:
    """Return where the switches stand that enable other parameters."""
    switches = {name for param in declaration.all_params.values() for name in param.enabled_when}
    return {name: value_of(node, declaration.all_params[name]) for name in switches}


def _draw_params(
    node: bpy.types.Node,
    layout: Any,
    declaration: Node,
    params: list[Param],
    written: dict[str, Any],
    values: dict[str, Any],
    *,
    drives: bool = False,
) -> None:
    for param in params:
        row = layout.row(align=True)
        row.active = declaration.is_enabled(param.name, values)
        drive = drive_in(written.get(param.name))
        if drive is not None:
            row.label(text=f"{param.label}: {_driven_value(node, param, drive)}", icon="DRIVER")
        else:
            _draw_param(node, row, param)
        if drives or drive is not None:
            button = row.operator("flowabs.drive", text="", icon="DRIVER", emboss=drive is not None)
            button.node, button.parameter = node.name, param.name


def _draw_param(node: bpy.types.Node, row: Any, param: Param) -> None:
    field = row
    if param.nullable:
        field = row.row(align=True)
        field.enabled = not getattr(node, AUTOMATIC + param.name)
    slider = param.kind == "float" and param.min == 0 and param.max == 1
    if param.kind in ("string", "custom", "file", "enum", "color"):
        split = field.split(factor=0.4, align=True)
        split.label(text=param.label)
        split.prop(node, property_name(param), text="")
    else:
        field.prop(node, property_name(param), slider=slider)
    if param.nullable:
        row.prop(node, AUTOMATIC + param.name, toggle=True)


def _driven_value(node: bpy.types.Node, param: Param, drive: dict[str, Any]) -> str:
    """Say where a driven parameter stands and what drives it: "1.25 (line_width)"."""
    tree, name = node.id_data, drive["from"]
    knob = tree.knobs.get(name)
    if knob is None:
        return f"no knob {name}"
    value, points = knobs.value_of(tree, knob), drive.get("map")
    if isinstance(points, list) and is_number(value):
        try:
            value = interpolate([(float(x), float(y)) for x, y in points], value)
        except (TypeError, ValueError, IndexError, ArithmeticError):
            return f"a wrong map ({name})"
        value = round(value) if param.kind == "int" else value
    shown = f"{value:.4g}" if isinstance(value, float) else str(value)
    return f"{shown} ({name}{', mapped' if points else ''})"
