"""Makes the JSON Schema (2020-12) of the graph file from the declarations: for editors, forms and other programs.

What a schema cannot say (that 3.0 is no whole number, links that lead somewhere, ports that fit, cycles, knobs that
fit) only :func:`check` says.
What panels need beside ``title``, ``description`` and ``default`` has keys of its own, which begin with ``x-``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from flowabs_nodes.graph import document_keys
from flowabs_nodes.graph.format import FORMAT, FRAME, KNOB_TYPES, MOST_NODES, NAME
from flowabs_nodes.graph.links import taken_names
from flowabs_nodes.graph.reference_size import MEASURES
from flowabs_nodes.nodes import catalogue as installed
from flowabs_nodes.nodes.declare import Node, Param, Port

Schema = dict[str, Any]


def schema(catalogue: Mapping[str, Node] | None = None) -> Schema:
    """Return the schema of graphs made of these nodes (all that are installed unless given)."""
    nodes = installed() if catalogue is None else catalogue
    properties = {key: dict(kind.schema) for key, kind in document_keys.GRAPH.items()}
    properties["format"] = {"const": FORMAT}
    properties["reference_height"] |= {
        "exclusiveMinimum": 0,
        "description": "The older spelling of reference_size's height.",
    }
    properties["reference_size"] |= {
        "properties": {measure: {"type": "number", "exclusiveMinimum": 0} for measure in MEASURES},
        "additionalProperties": False,
        "minProperties": 1,
        "maxProperties": 1,
        "description": "Size of the display window that pixel lengths are meant for; they grow with the plate.",
    }
    properties["interface"] |= {
        "propertyNames": {"$ref": "#/$defs/name"},
        "additionalProperties": {"$ref": "#/$defs/knob"},
    }
    properties["nodes"] |= {
        "propertyNames": {"$ref": "#/$defs/name"},
        "additionalProperties": {"$ref": "#/$defs/node"},
        "maxProperties": MOST_NODES,
    }
    properties["ui"]["description"] = "For editors: kept, never affects a result."
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "flowabs graph",
        "description": f"A graph of image nodes, {FORMAT}.",
        "$comment": "Whole numbers are written without a fraction: flowabs refuses 3.0, which is an integer here.",
        "type": "object",
        "properties": properties,
        "required": ["format", "nodes"],
        "not": {"required": ["reference_size", "reference_height"]},
        "additionalProperties": False,
        "$defs": {
            "name": {"type": "string", "pattern": f"^{NAME.pattern}$"},
            "link": {
                "description": 'A node (its first output), or "node.output".',
                "type": "string",
                "pattern": rf"^{NAME.pattern}(\.{NAME.pattern})?$",
            },
            "knob": _knob(),
            "from": _from(),
            "node": _any_node(nodes),
            **{f"node.{node.type}": _node(node) for node in nodes.values()},
        },
    }


def _knob() -> Schema:
    """Return the schema of a knob; its type decides what the default must be and which other keys there are."""
    numbers: Schema = {"min": {}, "max": {}}
    number, whole = {"type": "number"}, {"type": "integer"}
    by_type: dict[str, tuple[Schema, Schema]] = {
        "float": ({"anyOf": [number, _curve(number)]}, numbers),
        "int": ({"anyOf": [whole, _curve(whole)]}, dict.fromkeys(numbers, whole)),
        "bool": ({"type": "boolean"}, {}),
        "enum": ({"type": "string"}, {"choices": {}}),
        "string": ({"type": "string"}, {}),
        "color": (dict(_COLOR), {}),
    }
    rules: list[Schema] = []
    for kind in KNOB_TYPES:
        default, own = by_type[kind]
        then: Schema = {"properties": {"default": default, **own}}
        then["properties"] |= {key: False for key in ("min", "max", "choices") if key not in own}
        if kind == "enum":
            then["required"] = ["choices"]
        rules.append({"if": {"properties": {"type": {"const": kind}}, "required": ["type"]}, "then": then})
    properties = {key: dict(kind.schema) for key, kind in document_keys.KNOB.items()}
    properties["type"] = {"enum": list(KNOB_TYPES)}
    properties["choices"] |= {"items": {"type": "string"}, "minItems": 1, "uniqueItems": True}
    return {
        "description": "What the graph offers an artist; parameters take it with from.",
        "type": "object",
        "properties": properties,
        "required": ["type", "default"],
        "additionalProperties": False,
        "allOf": rules,
    }


def _any_node(nodes: Mapping[str, Node]) -> Schema:
    rules = []
    for node in nodes.values():
        is_type = {"properties": {"type": {"const": node.name}}, "required": ["type"]}
        rules.append({"if": is_type, "then": {"$ref": f"#/$defs/node.{node.type}"}})
    return {
        "type": "object",
        "properties": {
            "type": {"enum": [node.name for node in nodes.values()]},
            "inputs": {"type": "object"},
            "params": {"type": "object"},
        },
        "required": ["type"],
        "additionalProperties": False,
        "allOf": rules,
    }


def _node(node: Node) -> Schema:
    inputs: Schema = {"properties": {port.name: _input(port) for port in node.all_inputs.values()}}
    inputs["additionalProperties"] = _input(node.extra_inputs) if node.extra_inputs else False
    if node.extra_inputs:
        inputs["propertyNames"] = {"$ref": "#/$defs/name", "not": {"enum": taken_names(node)}}
    needed = [port.name for port in node.inputs if not port.optional]
    result: Schema = {"title": node.label, "description": node.help, "properties": {"inputs": inputs}}
    if needed:
        inputs["required"] = needed
        result["required"] = ["inputs"]
    params: Schema = {name: _param(param) for name, param in node.all_params.items()}
    result["properties"]["params"] = {"properties": params, "additionalProperties": False}
    required = [param.name for param in node.params if param.required and param.kind != "file"]
    if required:
        result["properties"]["params"]["required"] = required
        result["required"] = [*result.get("required", []), "params"]
    if node.outputs:
        result["x-outputs"] = {port.name: port.types for port in node.outputs}
    result["x-category"] = node.category
    result["x-region"], result["x-frames"] = node.region is not None, node.frames is not None
    return result


def _input(port: Port) -> Schema:
    return {"$ref": "#/$defs/link", "description": port.help, "x-port": port.types}


def _param(param: Param) -> Schema:
    """Return the schema of a parameter: a literal, a knob, or for numbers a curve; beside them help, default, unit."""
    literal = value(param)
    forms: list[Schema] = [literal, {"$ref": "#/$defs/from"}]
    number = {**literal, "type": literal["type"][0]} if param.nullable and param.numeric else literal
    forms[1] = {"$ref": "#/$defs/from", "properties": {"map": _points(number) if param.numeric else False}}
    if param.animatable:
        forms.append(_curve(number))
    result: Schema = {"title": param.label, "description": param.help}
    if not param.required:
        result["default"] = list(param.default) if isinstance(param.default, tuple) else param.default
    if param.unit:
        result["x-unit"] = param.unit
    if param.soft is not None:
        result["x-soft-min"], result["x-soft-max"] = param.soft
    if param.scales:
        result["x-scales"] = param.scales
    if param.group:
        result["x-group"] = param.group
    if param.enabled_when:
        result["x-enabled-when"] = {name: list(values) for name, values in param.enabled_when.items()}
    result["x-animatable"] = param.animatable
    if "examples" in param.schema:
        result["examples"] = param.schema["examples"]
    return {**result, "anyOf": forms}


def value(param: Param) -> Schema:
    """Return the schema of a literal value of the parameter."""
    kinds = {
        "float": "number",
        "int": "integer",
        "bool": "boolean",
        "enum": "string",
        "string": "string",
        "file": "string",
    }
    if param.kind == "custom":
        return _not_a_reference(dict(param.schema))
    if param.kind == "color":
        return dict(_COLOR)
    result: Schema = {"type": [kinds[param.kind], "null"] if param.nullable else kinds[param.kind]}
    if param.kind == "enum":
        result["enum"] = list(param.choices)
        result["x-enum-titles"] = list(param.choice_labels.values())
        if param.choice_meanings:
            result["enumDescriptions"] = [param.choice_meanings[choice] for choice in param.choices]
    if param.min is not None:
        result["exclusiveMinimum" if param.above else "minimum"] = _json_number(param.min)
    if param.max is not None:
        result["maximum"] = _json_number(param.max)
    return result


def _not_a_reference(literal: Schema) -> Schema:
    """Return the schema of a literal that no object with from or curve fits."""
    return {
        "allOf": [literal, {"not": {"anyOf": [{"type": "object", "required": [key]} for key in ("from", "curve")]}}]
    }


def _json_number(number: float) -> float | int:
    return int(number) if math.isfinite(number) and number == int(number) else number


_COLOR: Schema = {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}


def _from() -> Schema:
    return {
        "description": "The value of a knob, or what a piecewise linear map makes of it.",
        "type": "object",
        "properties": {"from": {"$ref": "#/$defs/name"}, "map": {}},
        "required": ["from"],
        "additionalProperties": False,
    }


def _curve(y: Schema) -> Schema:
    """Return the schema of ``{"curve": {frame: y, ...}}``."""
    keys: Schema = {"type": "object", "minProperties": 1, "additionalProperties": y}
    keys["propertyNames"] = {"pattern": f"^({FRAME.pattern})$"}
    return {"type": "object", "properties": {"curve": keys}, "required": ["curve"], "additionalProperties": False}


def _points(y: Schema) -> Schema:
    """Return the schema of a map's points [[x, y], ...]; that x increases, a schema cannot say."""
    point = {"type": "array", "prefixItems": [{"type": "number"}, y], "minItems": 2, "maxItems": 2}
    return {"type": "array", "items": point, "minItems": 2}
