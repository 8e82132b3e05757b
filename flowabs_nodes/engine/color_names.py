"""Checks the names of colour spaces that a graph gives, with the OCIO config that a run would use."""

from __future__ import annotations

from collections.abc import Collection

from flowabs_nodes.color.config import Config
from flowabs_nodes.color.named import find
from flowabs_nodes.errors import ColorError
from flowabs_nodes.graph.model import Graph
from flowabs_nodes.graph.problems import Problem, pointer, show
from flowabs_nodes.graph.values import FromKnob


def wrong_names(graph: Graph, config: Config, nodes: Collection[str] | None = None) -> list[Problem]:
    """Return a problem for each colour space that the config does not know, or cannot convert.

    ``nodes`` are those to look at, by default all. A space is tried: a look-up table that is missing is found here.
    """
    problems = []
    values = graph.values(1)
    for name, node in graph.nodes.items():
        for param in node.declaration.params:
            if param.colorspace is None or (nodes is not None and name not in nodes):
                continue
            value = values[name][param.name]
            if value in param.colorspace:
                continue
            try:
                find(value, config)
            except ColorError as error:
                known = error.code == "bad-colorspace"
                expected = f"a colour space of {config.name}" if known else "a colour space that can be converted"
                set_to = node.params.get(param.name)
                place = (
                    ("interface", set_to.knob, "default")
                    if isinstance(set_to, FromKnob)
                    else ("nodes", name, "params", param.name)
                )
                hint = error.hint if known else f"{error.message}{f' ({error.hint})' if error.hint else ''}"
                problems.append(Problem("bad-value", pointer(place), show(value), expected, hint))
    return problems
