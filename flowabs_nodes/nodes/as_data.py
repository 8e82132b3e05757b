"""Returns declarations as plain data, for ``flowabs nodes --json`` and other programs."""

from __future__ import annotations

from typing import Any

from flowabs_nodes.nodes.declare import Node, Param, Port


def node_data(node: Node) -> dict[str, Any]:
    """Return a node's declaration as JSON data: names and texts, its inputs, outputs and parameters.

    ``packages`` maps the modules that the node imports and that may not be installed to what pip installs them with.
    """
    return {
        "type": node.type,
        "version": node.version,
        "name": node.name,
        "label": node.label,
        "category": node.category,
        "help": node.help,
        "doc": node.doc,
        "packages": dict(node.packages),
        "inputs": [_port(port) for port in node.all_inputs.values()],
        "extra_inputs": _port(node.extra_inputs) if node.extra_inputs else None,
        "outputs": [_port(port) for port in node.all_outputs.values()],
        "params": [_param(param) for param in node.all_params.values()],
    }


def _port(port: Port) -> dict[str, Any]:
    """Return a port; its types are a list, empty for an output that is of the type of the input ``same_as``."""
    return {
        "name": port.name,
        "types": list(port.accepts),
        "same_as": port.same_as,
        "optional": port.optional,
        "help": port.help,
    }


def _param(param: Param) -> dict[str, Any]:
    """Return a parameter; ``above`` says that ``min`` itself is excluded, and null stands for a range without end."""
    return {
        "name": param.name,
        "kind": param.kind,
        "label": param.label,
        "group": param.group,
        "default": param.default,
        "required": param.required,
        "nullable": param.nullable,
        "min": param.min,
        "max": param.max,
        "above": param.above,
        "soft": param.soft,
        "unit": param.unit,
        "choices": list(param.choices),
        "enabled_when": {name: list(values) for name, values in param.enabled_when.items()},
        "animatable": param.animatable,
        "expected": param.expected,
        "help": param.help,
    }
