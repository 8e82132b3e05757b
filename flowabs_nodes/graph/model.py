"""A graph that has been found valid: nodes, the links between them, knobs, and what each parameter is set to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from flowabs_nodes.graph.format import KnobType
from flowabs_nodes.graph.problems import Problem, shortened, show
from flowabs_nodes.graph.reference_size import ReferenceSize
from flowabs_nodes.graph.values import Curve, Value
from flowabs_nodes.nodes.declare import Node, Param


@dataclass(frozen=True)
class Link:
    """Names the output that an input takes its images from."""

    node: str
    output: str

    def __str__(self) -> str:
        return f"{self.node}.{self.output}"


@dataclass(frozen=True)
class Knob:
    """Describes one control that a graph offers an artist.

    ``min`` and ``max`` are for numbers, ``choices`` for an enum. ``label`` is the name that people see, by default made
    of ``name``; ``group`` is the section of a panel. ``default`` is the value that the knob stands at, as the file has
    it; setting the knob makes a graph with another default. Of a number it may be ``{"curve": ...}``, which is read in
    ``curve``.
    """

    name: str
    type: KnobType
    default: Any
    min: float | None = None
    max: float | None = None
    unit: str = ""
    help: str = ""
    choices: tuple[str, ...] = ()
    label: str = ""
    group: str = ""
    curve: Curve | None = None

    def at(self, frame: int) -> Any:
        """Return the value that the knob stands at on a frame."""
        return self.default if self.curve is None else self.curve.at(frame, {})

    def __repr__(self) -> str:
        return f"<Knob {self.name} = {show(self.default)}: {self.param.expected}>"

    @property
    def param(self) -> Param:
        """Return the knob as a parameter, whose :meth:`~Param.problem` judges the knob's values."""
        return Param(
            name=self.name,
            kind=self.type,
            default=self.default,
            help=self.help,
            min=self.min,
            max=self.max,
            unit=self.unit,
            choices=self.choices,
            label=self.label,
            group=self.group,
        )


@dataclass(frozen=True)
class GraphNode:
    """Holds a node of a graph: its declaration, what its inputs are linked to, and the parameters the graph sets."""

    name: str
    declaration: Node
    inputs: Mapping[str, Link] = field(default_factory=dict)
    params: Mapping[str, Value] = field(default_factory=dict)

    def __repr__(self) -> str:
        links = ", ".join(f"{name}={link}" for name, link in self.inputs.items())
        return f"<GraphNode {self.name}: {self.declaration.name}({shortened(links)})>"


@dataclass(frozen=True)
class Graph:
    """Holds a valid graph, which nothing changes; :func:`~flowabs_nodes.graph.override` makes one with other values.

    Attributes
    ----------
    reference_size
        The size of the display window that the graph's pixel lengths are meant for; None where they are meant as
        written.
    nodes
        The nodes by name, each after the nodes whose results it needs.
    document
        The file as plain data (JSON), older versions brought up to date.
    source
        The path of the file, or "" for a graph made in memory.
    notes
        Sentences that say what was done to bring the document up to date.
    warnings
        Problems that do not keep the graph from running.
    """

    name: str
    description: str
    reference_size: ReferenceSize | None
    interface: Mapping[str, Knob]
    nodes: Mapping[str, GraphNode]
    ui: Mapping[str, Any]
    document: dict[str, Any]
    source: str = ""
    notes: tuple[str, ...] = ()
    warnings: tuple[Problem, ...] = ()

    def __repr__(self) -> str:
        knobs = ", ".join(f"{knob.name} {show(knob.default)}" for knob in self.interface.values())
        count = f"{len(self.nodes)} node{'' if len(self.nodes) == 1 else 's'}"
        source = f" of {self.source}" if self.source else ""
        return f"<{type(self).__name__} {self.name!r}{source}: {count}, knobs: {shortened(knobs) or 'none'}>"

    def values(self, frame: int) -> dict[str, dict[str, Any]]:
        """Return every parameter of every node at a frame, as the node's function takes it (lengths not scaled).

        Defaults are filled in, knobs stand at their default, and curves, of knobs and of parameters, are read at
        ``frame``. A file that is not set is left out.
        """
        knobs = {name: knob.at(frame) for name, knob in self.interface.items()}
        result = {}
        for name, node in self.nodes.items():
            declared = node.declaration.all_params
            values = node.declaration.defaults()
            values.update({param: value.at(frame, knobs) for param, value in node.params.items()})
            result[name] = {param: declared[param].check(value) for param, value in values.items()}
        return result
