"""A graph that has been found valid: nodes, the links between them, knobs, and what each parameter is set to."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from flowabs_nodes.graph.problems import Problem
from flowabs_nodes.graph.values import Value
from flowabs_nodes.nodes.declare import Node, Param

#: The format this version writes: its number grows when an older flowabs could not read the file.
FORMAT_NAME = "flowabs.graph"
FORMAT_VERSION = 1
FORMAT = f"{FORMAT_NAME}/{FORMAT_VERSION}"

#: Names of nodes, knobs and layers.
NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,127}")
NAME_RULE = "letters, digits and _, not starting with a digit, at most 128"

KnobType = Literal["float", "int", "bool", "enum", "string", "color"]
KNOB_TYPES: tuple[KnobType, ...] = ("float", "int", "bool", "enum", "string", "color")


@dataclass(frozen=True)
class Link:
    """Where an input comes from."""

    node: str
    output: str

    def __str__(self) -> str:
        return f"{self.node}.{self.output}"


@dataclass(frozen=True)
class Knob:
    """What a graph offers an artist. ``min`` and ``max`` are for numbers, ``choices`` for an enum."""

    name: str
    type: KnobType
    default: Any
    min: float | None = None
    max: float | None = None
    unit: str = ""
    help: str = ""
    choices: tuple[str, ...] = ()

    @property
    def param(self) -> Param:
        """The knob as a parameter: what its values have to be."""
        return Param(
            self.name, self.type, self.default, self.help, self.min, self.max, unit=self.unit, choices=self.choices
        )


@dataclass(frozen=True)
class GraphNode:
    """A node of a graph: its declaration, what its inputs are linked to, and the parameters the graph sets."""

    name: str
    declaration: Node
    inputs: Mapping[str, Link] = field(default_factory=dict)
    params: Mapping[str, Value] = field(default_factory=dict)


@dataclass(frozen=True)
class Graph:
    """A valid graph.

    Attributes
    ----------
    reference_height
        Display height that the graph's pixel lengths are meant for; None where they are meant as written.
    nodes
        In an order in which each comes after those it needs.
    document
        The file as plain data (JSON), older versions brought up to date.
    source
        Where it came from: a path, or "" for a graph made in memory.
    notes
        What was done to bring it up to date.
    warnings
        Problems that do not keep it from running.
    """

    name: str
    description: str
    reference_height: float | None
    interface: Mapping[str, Knob]
    nodes: Mapping[str, GraphNode]
    ui: Mapping[str, Any]
    document: dict[str, Any]
    source: str = ""
    notes: tuple[str, ...] = ()
    warnings: tuple[Problem, ...] = ()

    def values(self, frame: int) -> dict[str, dict[str, Any]]:
        """Every parameter of every node at a frame, as the node's function takes it (lengths not scaled).

        Defaults are filled in, knobs stand at their default, curves are read at ``frame``. A file that is not set is
        left out.
        """
        knobs = {name: knob.default for name, knob in self.interface.items()}
        result = {}
        for name, node in self.nodes.items():
            declared = node.declaration.all_params
            values = node.declaration.defaults()
            values.update({param: value.at(frame, knobs) for param, value in node.params.items()})
            result[name] = {param: declared[param].check(value) for param, value in values.items()}
        return result

    def with_set(self, values: Mapping[str, Any]) -> Graph:
        """The same graph with other values: ``{"knob": value, "node.parameter": value}``, as on the command line.

        A knob's value becomes its default; a parameter takes whatever the graph file may say there. Raises GraphError
        with everything that is wrong, each at ``--set name``.
        """
        from flowabs_nodes.graph.overrides import override  # it validates, which needs this module

        return override(self, values)
