"""Checks that what a node chooses among its inputs is linked: the branch that a switch stands at."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from flowabs_nodes.errors import FlowabsError, unforeseen
from flowabs_nodes.graph.model import GraphNode, Knob
from flowabs_nodes.graph.problems import Problems, show
from flowabs_nodes.graph.values import Curve


def add_unlinked_choices(nodes: Iterable[GraphNode], knobs: Mapping[str, Knob], problems: Problems) -> None:
    """Add a problem for each input that a node needs, with knobs at their current values, and that is not linked.

    Where a parameter moves along a curve, its keys are looked at.

    Raises
    ------
    FlowabsError
        Whatever a node's function raises that says what it needs, with the node.
    """
    standing = {name: knob.default for name, knob in knobs.items()}
    for node in nodes:
        if node.declaration.needs is None:
            continue
        missing: dict[str, dict[str, Any]] = {}
        for values in _values(node, standing):
            for name in _needs(node, values):
                if name not in node.inputs:
                    missing.setdefault(name, values)
        for name, values in missing.items():
            chosen = ", ".join(f"{param} {show(values[param])}" for param in node.params) or "the default"
            linked = f"linked: {', '.join(node.inputs)}"
            place = ("nodes", node.name, "inputs", name)
            problems.add("missing-input", place, "nothing", f"a link, which {chosen} asks for", linked)


def _needs(node: GraphNode, values: Mapping[str, Any]) -> Iterable[str]:
    """Return the inputs that a node needs with these parameters, as its own function says."""
    assert node.declaration.needs is not None
    try:
        return node.declaration.needs(values)
    except FlowabsError as error:
        raise error.at(node=node.name)  # noqa: B904 - the same error, with its place
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # another package may fail in any way
        raise unforeseen(error).at(node=node.name) from error


def _values(node: GraphNode, standing: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield all parameters of a node, at every key of its curves; once where it has none."""
    frames = {frame for value in node.params.values() if isinstance(value, Curve) for frame, _ in value.keys}
    for frame in sorted(frames) or [1]:
        set_here = {name: value.at(frame, standing) for name, value in node.params.items()}
        yield node.declaration.defaults() | set_here
