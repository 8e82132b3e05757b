"""A run as data: what a process needs to know to make any one of its frames."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any

from flowabs_nodes import graph as graphs
from flowabs_nodes.graph.model import Graph
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.nodes.declare import Node


@dataclass(frozen=True)
class Job:
    """Frames to make of one graph. It can be pickled: the graph travels as its document.

    Attributes
    ----------
    document
        The graph, with everything set that this run sets.
    outputs
        For each write node, the files or patterns that its picture goes to.
    existing
        What to do about files that are there already.
    missing
        Policy for missing input frames, instead of the nodes' own; None leaves it to them.
    catalogue
        Node declarations by type, for graphs of other nodes than those that are installed.
    """

    document: Mapping[str, Any]
    outputs: Mapping[str, tuple[str, ...]]
    settings: Settings = field(default_factory=Settings)
    scale: float = 1.0
    existing: str = "resume"
    missing: str | None = None
    catalogue: Mapping[str, Node] | None = None

    @cached_property
    def graph(self) -> Graph:
        """Read once in each process."""
        return graphs.load(self.document, self.catalogue)

    def __getstate__(self) -> dict[str, Any]:
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
