"""The parameters of every unit, by frame, and the frames that a unit asks for by them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from flowabs_nodes.engine.error_boundary import error_boundary
from flowabs_nodes.engine.plan import Unit
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
