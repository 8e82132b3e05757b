"""Warns of what a graph sets to no effect.

That is a parameter which the graph's own settings disable, such as XDoG's phi in a paper-style drawing, and a knob that
changes nothing.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any

from flowabs_nodes.graph.model import GraphNode, Knob
from flowabs_nodes.graph.problems import Problems, show
from flowabs_nodes.graph.values import FromKnob, Literal, Value
from flowabs_nodes.nodes.declare import Param


def add_unused_params(nodes: Iterable[GraphNode], knobs: Mapping[str, Knob], problems: Problems) -> None:
    """Add a warning for each parameter that is set and does nothing, with knobs at their current values."""
    standing = {name: knob.at(0) for name, knob in knobs.items()}
    for node in nodes:
        declared = node.declaration.all_params
        conditional = [name for name in node.params if declared[name].enabled_when]
        if not conditional:
            continue
        # Enums and bools take no curve: what they are set to is the same on every frame.
        switches = {name for param in conditional for name in declared[param].enabled_when}
        values = {name: node.params[name].at(0, standing) for name in switches if name in node.params}
        for name in conditional:
            if not node.declaration.is_enabled(name, values):
                _add(node, declared[name], values, problems)


def add_unused_knobs(
    nodes: Iterable[GraphNode], knobs: Mapping[str, Knob], idle: Collection[str], problems: Problems
) -> None:
    """Add a warning for each knob that changes nothing, wherever it stands; ``idle`` are nodes that nothing needs."""
    driven: dict[str, list[str]] = {name: [] for name in knobs}  # for each parameter, why it does not count, or ""
    for node in nodes:
        for name, value in node.params.items():
            if isinstance(value, FromKnob):
                driven[value.knob].append(_why_idle(node, name, value, idle))
    for name, whys in driven.items():
        if all(whys):
            reasons = "; ".join(whys[:3])
            found = f"the knob {name}, which " + (f"changes nothing: {reasons}" if reasons else "drives nothing")
            expected = f'a parameter set to {{"from": {show(name)}}}'
            problems.add("unused-knob", ("interface", name), found, expected, "leave it out", warning=True)


def _why_idle(node: GraphNode, param: str, value: FromKnob, idle: Collection[str]) -> str:
    """Return why a knob that drives a parameter changes nothing by it; "" where it does."""
    if node.name in idle:
        return f"nothing needs {node.name}, of which it drives {param}"
    results = {y for _, y in value.map}
    return f"{node.name}.{param} is {show(results.pop())} everywhere on its map" if len(results) == 1 else ""


def _add(node: GraphNode, param: Param, values: Mapping[str, Any], problems: Problems) -> None:
    """Add the warning about one parameter of ``node``, whose switches stand at ``values``."""
    declared = node.declaration.all_params
    wrong, wanted, knobs = [], [], []
    for switch, enabling in param.enabled_when.items():
        value = values.get(switch, declared[switch].default)
        if value not in enabling:
            wrong.append(f"{switch} {show(value)}")
            wanted.append(f"{switch} {' or '.join(map(show, enabling))}")
            source = node.params.get(switch)
            knobs += [source.knob] if isinstance(source, FromKnob) else []
    found = f"{param.name}{_shown(node.params[param.name])}, which does nothing beside {' and '.join(wrong)}"
    hint = f"leave {param.name} out"
    hint += f", or turn the knob {' and '.join(map(repr, knobs))}" if knobs else ", or change what disables it"
    place = ("nodes", node.name, "params", param.name)
    problems.add("unused-param", place, found, f"{' and '.join(wanted)} for {param.name}", hint, warning=True)


def _shown(value: Value) -> str:
    """Return a literal as it stands in the file, after a space; nothing for a value that comes of a knob or a curve."""
    return f" {show(value.value)}" if isinstance(value, Literal) else ""
