"""Plans what to compute for some outputs, in which order, and when each result is no longer needed.

The unit of work is a node on a frame. Today a node looks at its own frame alone: :func:`inputs_of` says so here. A node
that looks at its input on other frames as well also needs parameters and sources of those frames, which
:mod:`~flowabs_nodes.engine.render_frame` makes for one frame.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from flowabs_nodes.errors import CommandError, nearest
from flowabs_nodes.port_types import TYPES

if TYPE_CHECKING:
    from flowabs_nodes.graph.model import Graph


class Unit(NamedTuple):
    """A node on a frame."""

    node: str
    frame: int


class Result(NamedTuple):
    """One output of a node on a frame: what is computed once, and dropped after its last use."""

    node: str
    output: str
    frame: int

    @property
    def unit(self) -> Unit:
        """The unit that computes this result."""
        return Unit(self.node, self.frame)


@dataclass(frozen=True)
class Step:
    """One unit's turn: its inputs, the outputs that are asked for, and the results that no later step needs."""

    unit: Unit
    inputs: Mapping[str, Result]
    wanted: frozenset[str]
    drops: frozenset[Result]


def make_plan(
    graph: Graph,
    frame: int,
    *,
    results: Iterable[Result] = (),
    sinks: Iterable[str] = (),
    given: Collection[Result] = (),
) -> tuple[Step, ...]:
    """Order the steps that compute ``results`` and run the nodes ``sinks``, on one frame.

    A ``given`` result is not computed, nor anything that only it would need. Each branch is finished before the next
    one begins, and the branch with the smallest result comes first, so that little is held at a time.
    """
    results = tuple(results)
    needs: dict[Unit, dict[str, Result]] = {}  # in the order of work
    for sink in sinks:
        _add_upstream_first(graph, Unit(sink, frame), given, needs)
    for result in results:
        if result not in given:
            _add_upstream_first(graph, result.unit, given, needs)

    wanted: dict[Unit, set[str]] = {}
    last_use: dict[Result, Unit] = {}
    for unit, inputs in needs.items():
        for needed in inputs.values():
            wanted.setdefault(needed.unit, set()).add(needed.output)
            last_use[needed] = unit
    for result in results:
        wanted.setdefault(result.unit, set()).add(result.output)
        last_use.pop(result, None)
    drops: dict[Unit, set[Result]] = {}
    for result, unit in last_use.items():
        drops.setdefault(unit, set()).add(result)
    given_outputs: dict[Unit, set[str]] = {}
    for result in given:
        given_outputs.setdefault(result.unit, set()).add(result.output)
    return tuple(
        Step(
            unit=unit,
            inputs=inputs,
            wanted=frozenset(wanted.get(unit, set()) - given_outputs.get(unit, set())),
            drops=frozenset(drops.get(unit, set())),
        )
        for unit, inputs in needs.items()
    )


def inputs_of(graph: Graph, unit: Unit) -> dict[str, Result]:
    """Return the results that a unit needs, by the name of its input."""
    links = graph.nodes[unit.node].inputs
    return {name: Result(link.node, link.output, unit.frame) for name, link in links.items()}


def _add_upstream_first(
    graph: Graph, target: Unit, given: Collection[Result], needs: dict[Unit, dict[str, Result]]
) -> None:
    """Add ``target`` and every unit that it depends on to ``needs``, each after all units that it depends on itself."""
    stack = [(target, False)]  # not by recursion: a chain may be thousands of nodes long
    while stack:
        unit, ready = stack.pop()
        if unit in needs:
            continue
        inputs = inputs_of(graph, unit)
        if ready:
            needs[unit] = inputs
            continue
        stack.append((unit, True))
        small_first = sorted(inputs.values(), key=lambda each: _bytes_per_pixel(graph, each))
        stack.extend((each.unit, False) for each in reversed(small_first) if each not in given)


def _bytes_per_pixel(graph: Graph, result: Result) -> int:
    """Return about how many bytes a pixel of a result takes in memory; of a type that is an input's, as a color."""
    port = graph.nodes[result.node].declaration.all_outputs[result.output]
    return TYPES[port.types if port.same_as is None else "color"].bytes_per_pixel


# ---------------------------------------------------------------------- names that a caller writes


def sinks(graph: Graph) -> tuple[str, ...]:
    """Return the nodes that a run pulls from: those that write a file."""
    return tuple(name for name, node in graph.nodes.items() if file_role(graph, name) == "output")


def file_role(graph: Graph, name: str) -> str:
    """Return "input" for a node that reads a file, "output" for one that writes, else ""."""
    param = graph.nodes[name].declaration.file_param
    return param.role if param else ""


def named_result(graph: Graph, name: str, frame: int) -> Result:
    """Return the result that ``"node"`` (its first output) or ``"node.output"`` names on a frame.

    Raises
    ------
    CommandError
        unknown-node or unknown-output, with the nearest right name.
    """
    node, _, output = name.partition(".")
    if node not in graph.nodes:
        raise CommandError(f"the graph has no node {node!r}", code="unknown-node", hint=nearest(node, graph.nodes))
    outputs = graph.nodes[node].declaration.all_outputs
    if not outputs:
        hint = "ask for what goes into it"
        raise CommandError(f"node {node!r} only writes, it has no outputs", code="unknown-output", hint=hint)
    if not output:
        output = next(iter(outputs))
    if output not in outputs:
        raise CommandError(
            f"node {node!r} has no output {output!r}", code="unknown-output", hint=nearest(output, outputs)
        )
    return Result(node, output, frame)
