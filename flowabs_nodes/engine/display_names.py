"""Checks the displays and views that a graph names, with the OCIO config that a run would use."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from flowabs_nodes.color.config import Ocio
from flowabs_nodes.errors import ColorError
from flowabs_nodes.graph.model import Graph, GraphNode
from flowabs_nodes.graph.problems import Place, Problem, pointer, show
from flowabs_nodes.graph.values import FromKnob


def wrong_views(graph: Graph, ocio: Ocio, nodes: Collection[str] | None = None) -> list[Problem]:
    """Return a problem for each display and view that the config does not have, and for a colour space beside one.

    ``ocio`` is the config, None the built-in one; it is read only where a node names a display or view. ``nodes`` are
    those to look at, by default all.
    """
    problems = []
    values = graph.values(1)
    for name, node in graph.nodes.items():
        params: dict[str, str] = {each.of_config: each.name for each in node.declaration.params if each.of_config}
        asked: dict[str, str] = {kind: values[name][param] for kind, param in params.items()}
        if any(asked.values()) and (nodes is None or name in nodes):
            problems += _problems(node, values[name], params, asked, ocio)
    return problems


def _problems(
    node: GraphNode, values: dict[str, Any], params: dict[str, str], asked: dict[str, str], ocio: Ocio
) -> list[Problem]:
    """Return what is wrong with the display and view of one node."""
    from flowabs_nodes.color.display import find_view  # OpenImageIO, which a graph without views need not have

    if values.get("colorspace", "plate") != "plate":
        place = _place(node, "colorspace")
        expected = '"plate" beside a display or view, which say themselves how colours are encoded'
        return [Problem("bad-value", pointer(place), show(values["colorspace"]), expected)]
    try:
        find_view(asked["display"], asked["view"], ocio)
    except ColorError as error:
        kind = error.code.removeprefix("unknown-")
        if kind not in params:
            raise
        found, _, has = error.message.partition(": it has ")
        expected = f"one of {has}" if has else found
        return [Problem("bad-value", pointer(_place(node, params[kind])), show(asked[kind]), expected, error.hint)]
    return []


def _place(node: GraphNode, param: str) -> Place:
    """Return where a parameter's value stands in the graph: at the node, or at the knob that it comes from."""
    value = node.params.get(param)
    if isinstance(value, FromKnob):
        return ("interface", value.knob, "default")
    return ("nodes", node.name, "params", param)
