"""Plans what to compute for some outputs, in which order, and when each result is no longer needed.

The unit of work is a node on a frame. Most nodes read their inputs on their own frame alone. A node whose declaration
has ``frames`` reads them on other frames too, and these may be results of such nodes again: offsets add up.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

from flowabs_nodes.errors import ArgumentError, CommandError, nearest
from flowabs_nodes.port_types import TYPES

if TYPE_CHECKING:
    from flowabs_nodes.graph.model import Graph

_NO_OFFSETS: Mapping[str, Iterable[int]] = MappingProxyType({})


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
        """Return the unit that computes this result."""
        return Unit(self.node, self.frame)


#: What a unit reads, by the name of its input: a result, or a dict from frame offset to result, in order of offsets.
Inputs = Mapping[str, Result | Mapping[int, Result]]


@dataclass(frozen=True)
class Step:
    """One unit's turn: its inputs, the outputs that are asked for, and the results that no later step needs."""

    unit: Unit
    inputs: Inputs
    wanted: frozenset[str]
    drops: frozenset[Result]

    @property
    def needs(self) -> tuple[Result, ...]:
        """Every result that the unit reads, of all inputs and frames."""
        return tuple(results_in(self.inputs))

    @property
    def makes(self) -> tuple[Result, ...]:
        """Every result that the step computes."""
        return tuple(Result(self.unit.node, output, self.unit.frame) for output in self.wanted)


def make_plan(
    graph: Graph,
    frame: int,
    *,
    results: Iterable[Result] = (),
    sinks: Iterable[str] = (),
    given: Collection[Result] = (),
    inputs_of: Callable[[Unit], Inputs] | None = None,
) -> tuple[Step, ...]:
    """Order the steps that compute ``results`` and run the nodes ``sinks``, on one frame.

    A ``given`` result is not computed, nor anything that only it would need. Each branch is finished before the next
    one begins, and the branch with the smallest result comes first, so that little is held at a time.

    ``inputs_of`` says what a unit reads (:meth:`flowabs_nodes.engine.frame_windows.FrameWindows.inputs_of`); without it
    every node reads its own frame alone.
    """
    results = tuple(results)
    if inputs_of is None:
        inputs_of = partial(unit_inputs, graph)
    needs: dict[Unit, Inputs] = {}  # in the order of work
    for sink in sinks:
        _add_upstream_first(graph, inputs_of, Unit(sink, frame), given, needs)
    for result in results:
        if result not in given:
            _add_upstream_first(graph, inputs_of, result.unit, given, needs)

    wanted: dict[Unit, set[str]] = {}
    last_use: dict[Result, Unit] = {}
    for unit, inputs in needs.items():
        for needed in results_in(inputs):
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


def unit_inputs(
    graph: Graph,
    unit: Unit,
    offsets: Mapping[str, Iterable[int]] = _NO_OFFSETS,
    needed: Collection[str] | None = None,
) -> dict[str, Any]:
    """Return what a unit reads (:data:`Inputs`), if the inputs in ``offsets`` are read on these frames.

    Of its inputs those that are ``needed`` count, all without it.
    """
    found: dict[str, Any] = {}
    for name, link in graph.nodes[unit.node].inputs.items():
        if needed is not None and name not in needed:
            continue
        if name in offsets:
            found[name] = {each: Result(link.node, link.output, unit.frame + each) for each in offsets[name]}
        else:
            found[name] = Result(link.node, link.output, unit.frame)
    return found


def results_in(inputs: Inputs) -> Iterator[Result]:
    """Yield every result that a unit reads, of all inputs and frames."""
    for needed in inputs.values():
        if isinstance(needed, Result):
            yield needed
        else:
            yield from needed.values()


def _add_upstream_first(
    graph: Graph,
    inputs_of: Callable[[Unit], Inputs],
    target: Unit,
    given: Collection[Result],
    needs: dict[Unit, Inputs],
) -> None:
    """Add ``target`` and every unit that it depends on to ``needs``, each after all units that it depends on itself."""
    # Not by recursion: a chain may be thousands of nodes long.
    stack: list[tuple[Unit, Inputs | None]] = [(target, None)]
    while stack:
        unit, inputs = stack.pop()
        if unit in needs:
            continue
        if inputs is not None:  # everything upstream of the unit has been added
            needs[unit] = inputs
            continue
        inputs = inputs_of(unit)
        stack.append((unit, inputs))
        small_first = sorted(results_in(inputs), key=lambda each: _bytes_per_pixel(graph, each))
        stack.extend((each.unit, None) for each in reversed(small_first) if each not in given)


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
        links = dict.fromkeys(str(link) for link in graph.nodes[node].inputs.values())
        hint = f"ask for what goes into it: {', '.join(links)}" if links else ""
        raise CommandError(f"node {node!r} only writes, it has no outputs", code="unknown-output", hint=hint)
    if not output:
        output = next(iter(outputs))
    if output not in outputs:
        hint = nearest(output, outputs)
        hint = hint if hint.startswith("known") else f"{hint} known: {', '.join(outputs)}"
        raise CommandError(f"node {node!r} has no output {output!r}", code="unknown-output", hint=hint)
    return Result(node, output, frame)


def output_names(graph: Graph, outputs: str | Iterable[str] | None) -> tuple[str, ...]:
    """Return the names in ``outputs``, a list of them or a single one; of None those that go into write nodes.

    Raises
    ------
    ArgumentError
        ``outputs`` is anything else.
    CommandError
        no-write: it is None, and the graph writes nothing.
    """
    if outputs is None:
        return _written_outputs(graph)
    names = (outputs,) if isinstance(outputs, str) else tuple(outputs) if isinstance(outputs, Iterable) else (outputs,)
    for name in names:
        if not isinstance(name, str):
            raise ArgumentError(
                f"outputs: expected names such as 'lines' or ['lines', 'comp.ink'], found {name!r}",
                code="wrong-type",
                parameter="outputs",
            )
    return names


def _written_outputs(graph: Graph) -> tuple[str, ...]:
    """Return the names of all outputs that go into the graph's write nodes."""
    names: dict[str, None] = {}
    for sink in sinks(graph):
        for link in graph.nodes[sink].inputs.values():
            first = next(iter(graph.nodes[link.node].declaration.all_outputs))
            names[link.node if link.output == first else f"{link.node}.{link.output}"] = None
    if not names:
        raise CommandError(
            "the graph writes nothing", code="no-write", hint="say which outputs you want: outputs=[...]"
        )
    return tuple(names)
