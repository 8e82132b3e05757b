"""The parameters of every unit, by frame, and the frames that a unit asks for by them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from flowabs_nodes.engine.error_boundary import error_boundary
from flowabs_nodes.engine.plan import Inputs, Unit, unit_inputs
from flowabs_nodes.graph.values import Curve
from flowabs_nodes.nodes.frame_offsets import frame_offsets

if TYPE_CHECKING:
    from flowabs_nodes.graph.model import Graph

#: A node's parameters by name.
Params = Mapping[str, Any]


class UnitParams(dict[Unit, Params]):
    """Each unit's parameters, lengths not scaled; those of a frame are computed when the first of them is asked for."""

    def __init__(self, graph: Graph) -> None:
        super().__init__()
        self._graph = graph

    def __missing__(self, unit: Unit) -> Params:
        with error_boundary(frame=unit.frame):
            self.update({Unit(node, unit.frame): values for node, values in self._graph.values(unit.frame).items()})
        return super().__getitem__(unit)


def unit_offsets(graph: Graph, unit: Unit, params: Mapping[Unit, Params]) -> dict[str, tuple[int, ...]]:
    """Return the offsets of the frames that a unit reads, by input, of all inputs that it reads on several frames.

    Raises
    ------
    FlowabsError
        wrong-frames, or whatever the node's ``frames`` raises, with node and frame.
    """
    declaration = graph.nodes[unit.node].declaration
    if declaration.frames is None:
        return {}
    with error_boundary(unit.node, unit.frame):
        return frame_offsets(declaration, params[unit])


def needed_inputs(graph: Graph, unit: Unit, params: Mapping[Unit, Params]) -> tuple[str, ...] | None:
    """Return the names of the inputs that a unit needs on its frame; None where it needs all that are connected.

    Raises
    ------
    FlowabsError
        missing-input, with node and frame, where it needs one that is not connected.
    """
    node = graph.nodes[unit.node]
    if node.declaration.needs is None:
        return None
    with error_boundary(unit.node, unit.frame):
        return node.declaration.needed(node.inputs, params[unit])


def chooses_inputs(graph: Graph) -> bool:
    """Return whether the graph has a node that needs some of its inputs only."""
    return any(node.declaration.needs is not None for node in graph.nodes.values())


def reads_other_frames(graph: Graph) -> bool:
    """Return whether the graph has a node that reads its inputs on other frames too."""
    return any(node.declaration.frames is not None for node in graph.nodes.values())


def inputs_on_any_frame(graph: Graph, unit: Unit, params: Mapping[Unit, Params]) -> Inputs:
    """Return what a unit reads of its own frame, and what it would read of it with its parameters of other frames.

    A node whose parameters move along curves counts as needing all of its inputs.
    """
    moves = any(isinstance(value, Curve) for value in graph.nodes[unit.node].params.values())
    return unit_inputs(graph, unit, needed=None if moves else needed_inputs(graph, unit, params))
