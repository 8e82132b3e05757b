"""Sets knobs and parameters of a graph from outside: ``--set knob=value``, ``--set node.parameter=value``."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.graph.jsonable import jsonable
from flowabs_nodes.graph.model import Graph
from flowabs_nodes.graph.problems import GraphError, Place, Problem, Problems, pointer, show
from flowabs_nodes.graph.safe_json import parse
from flowabs_nodes.graph.validate import validate


def parse_setting(text: str) -> Any:
    """Return the value that a text of the command line means: JSON if it parses (finite, no key twice), else itself."""
    problems = Problems()
    try:
        value = parse(text.encode("utf-8", "surrogateescape"), problems)
    except GraphError:
        return text
    return text if problems.found else value


def override(graph: Graph, values: Mapping[str, Any]) -> Graph:
    """Return the graph with other values: ``{"knob": value, "node.parameter": value}``, as on the command line.

    A knob's value becomes its default; a parameter takes whatever the graph file may say there. Raises GraphError with
    everything that is wrong, each problem at a place like ``--set lines.rho``; ArgumentError where ``values`` is no
    dict from names to values.
    """
    _needs_names(values)
    document = copy.deepcopy(graph.document)
    wrong: list[Problem] = []
    places: dict[str, str] = {}
    for name, value in values.items():
        here = f"--set {name}"
        place = _find(graph, name, here, wrong)
        if place is None:
            continue
        problems = Problems()
        try:
            data = jsonable(value, problems)
        except GraphError as error:
            problems.found.extend(error.problems)
        if problems.found:
            wrong.extend(
                replace(problem, code="bad-value", pointer=here + problem.pointer) for problem in problems.found
            )
            continue
        owner = document
        for key in place[:-1]:
            owner = owner.setdefault(str(key), {})
        owner[str(place[-1])] = data
        places[pointer(place)] = here
    problems = Problems()
    catalogue = {node.declaration.type: node.declaration for node in graph.nodes.values()}
    result = validate(document, catalogue, problems, graph.source)
    errors = wrong + [_renamed(problem, places) for problem in problems.found if not problem.warning]
    if errors or result is None:
        raise GraphError(errors, file=graph.source or None)
    warnings = tuple(_renamed(problem, places) for problem in result.warnings if _is_news(problem, graph))
    return replace(result, notes=graph.notes, warnings=warnings)


def _needs_names(values: Any) -> None:
    """Raise ArgumentError unless ``values`` is a dict from names to values."""
    found = None if isinstance(values, Mapping) else type(values).__name__
    if found is None:
        found = next((f"the name {name!r}" for name in values if not isinstance(name, str)), None)
    if found is not None:
        raise ArgumentError(
            f'set: expected a dict such as {{"knob": 1, "node.parameter": 2}}, found {found}',
            code="wrong-type",
            parameter="set",
        )


def _find(graph: Graph, name: str, here: str, wrong: list[Problem]) -> Place | None:
    """Find where the document holds the knob or parameter ``name``; None, and a problem in ``wrong``, if nowhere."""
    problems = Problems()
    node, dot, param = name.partition(".")
    known = [f"{n}.{p}" for n, found in graph.nodes.items() if n == node for p in found.declaration.all_params]
    if not dot:
        if name in graph.interface:
            return ("interface", name, "default")
        if name in graph.nodes:
            hint = f"{name} is a node: set {name}.PARAMETER"
        else:
            hint = problems.near(name, [*graph.interface, *graph.nodes])
        wrong.append(Problem("unknown-param", here, show(name), "a knob, or node.parameter", hint))
    elif node not in graph.nodes:
        hint = problems.near(node, graph.nodes)
        wrong.append(Problem("unknown-node", here, show(node), "a node of this graph", hint))
    elif name not in known:
        declaration = graph.nodes[node].declaration
        is_input = f"{param} is an input: link it in the graph's file" if param in declaration.all_inputs else ""
        hint = is_input or problems.near(name, known)
        wrong.append(Problem("unknown-param", here, show(param), f"a parameter of {declaration.name}", hint))
    else:
        return ("nodes", node, "params", param)
    return None


def _is_news(problem: Problem, graph: Graph) -> bool:
    """Return False for a knob that drives nothing only because a setting took its place."""
    return problem.code != "unused-knob" or problem in graph.warnings


def _renamed(problem: Problem, places: Mapping[str, str]) -> Problem:
    """Return the problem with its pointer changed to the setting that made it."""
    for place, here in places.items():
        if problem.pointer == place or problem.pointer.startswith(place + "/"):
            return replace(problem, pointer=here + problem.pointer[len(place) :])
    return problem
