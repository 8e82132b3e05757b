"""The knobs of a graph as a panel shows them: label, group, range, where each stands, and whether it does anything."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from flowabs_nodes.engine.plan import Unit
from flowabs_nodes.engine.unit_params import UnitParams, needed_inputs
from flowabs_nodes.graph.values import FromKnob

if TYPE_CHECKING:
    from flowabs_nodes.graph.model import Graph


@dataclass(frozen=True)
class KnobState:
    """Describes a knob and where it stands.

    Attributes
    ----------
    name, type, unit, help, choices, min, max
        As the graph declares them.
    label, group
        What people read, and the section of the panel; "" is no section.
    value, default
        Where it stands on the frame that was asked for, and where the graph has it.
    animated
        Whether it moves along a curve.
    enabled
        Whether turning it changes anything, with the other knobs as they stand.
    """

    name: str
    type: str
    label: str
    group: str
    value: Any
    default: Any
    min: float | None
    max: float | None
    unit: str
    help: str
    choices: tuple[str, ...]
    animated: bool
    enabled: bool


def knob_states(loaded: Graph, graph: Graph, frame: int) -> tuple[KnobState, ...]:
    """Return every knob of ``graph``, which is ``loaded`` with values set, on a frame."""
    enabled = _enabled(graph, frame)
    return tuple(
        KnobState(
            name=name,
            type=knob.type,
            label=knob.param.label,
            group=knob.group,
            value=knob.at(frame),
            default=loaded.interface[name].at(frame),
            min=knob.min,
            max=knob.max,
            unit=knob.unit,
            help=knob.help,
            choices=knob.choices,
            animated=knob.curve is not None,
            enabled=name in enabled,
        )
        for name, knob in graph.interface.items()
    )


def _enabled(graph: Graph, frame: int) -> set[str]:
    """Return the knobs that drive a parameter which does something on a frame, of a node that is not passed over."""
    params = UnitParams(graph)
    found = set()
    for name in _used_nodes(graph, frame, params):
        node, values = graph.nodes[name], params[Unit(name, frame)]
        for param, value in node.params.items():
            if isinstance(value, FromKnob) and node.declaration.is_enabled(param, values):
                found.add(value.knob)
    return found


def _used_nodes(graph: Graph, frame: int, params: UnitParams) -> set[str]:
    """Return the nodes that some node without followers needs, by the inputs that each chooses on the frame."""
    followed = {link.node for node in graph.nodes.values() for link in node.inputs.values()}
    stack = [name for name in graph.nodes if name not in followed]
    used: set[str] = set()
    while stack:
        name = stack.pop()
        if name not in used:
            used.add(name)
            inputs = graph.nodes[name].inputs
            needed = needed_inputs(graph, Unit(name, frame), params)
            stack += [inputs[each].node for each in (inputs if needed is None else needed)]
    return used
