"""A run as data: what a process needs to know to make any one of its frames."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any

from flowabs_nodes import graph as graphs
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.graph.model import Graph
from flowabs_nodes.nodes.declare import Node


@dataclass(frozen=True)
class Job:
    """One graph and how its frames are made. A job can be pickled: the graph travels as its document.

    Attributes
    ----------
    document
        The graph, with everything set that this run sets.
    outputs
        For each write node, the files or patterns that its picture goes to.
    options
        The options that a single frame depends on (:meth:`RunOptions.for_frames`).
    catalogue
        Node declarations by type, for graphs of other nodes than those that are installed.
    """

    document: Mapping[str, Any]
    outputs: Mapping[str, tuple[str, ...]]
    options: RunOptions = field(default_factory=RunOptions)
    catalogue: Mapping[str, Node] | None = None

    def __repr__(self) -> str:
        files = ", ".join(file for files in self.outputs.values() for file in files)
        return f"<Job {self.document.get('name', '')!r} -> {files}>"

    @cached_property
    def graph(self) -> Graph:
        """Return the graph, parsed once in each process."""
        return graphs.load(self.document, self.catalogue)

    def __getstate__(self) -> dict[str, Any]:
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
