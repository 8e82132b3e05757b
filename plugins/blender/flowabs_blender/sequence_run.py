"""Runs a graph over rendered frames, from files to files, by the engine of ``flowabs run``: in processes, resumable."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import flowabs_nodes
from flowabs_nodes import Report, RunnableGraph, load_graph
from flowabs_nodes.engine.plan import sinks
from flowabs_nodes.engine.runnable import GraphSource

from .background import Background
from .outputs import writing_only
from .plates import with_picture


@dataclass(frozen=True)
class SequenceRun:
    """What to run over which frames; calling it does the work.

    Attributes
    ----------
    graph
        A document, a path, or the name of a graph that comes with flowabs.
    input, output
        Patterns such as ``shot.####.exr``: the frames, and what to write. ``output`` goes to the graph's write node; of
        several to each that has no file, with the node's name before the pattern's from the second one on.
    frames
        A range such as "1-100x2,200".
    chosen
        The one output to write, "node" or "node.output"; "" for whatever the graph writes.
    existing, scale
        As :class:`~flowabs_nodes.engine.options.RunOptions` has them.
    """

    graph: GraphSource
    input: str
    output: str
    frames: str
    chosen: str = ""
    existing: str = "resume"
    scale: float = 1.0

    def __call__(self, background: Background[Report]) -> Report:
        """Return what became of each frame. Raises FlowabsError where the run cannot begin."""
        graph = load_graph(self.graph)
        graph = writing_only(graph, self.chosen) if self.chosen else graph
        graph, _ = with_picture(graph, Path(self.input))
        graph = graph.with_set(self._files(graph))
        return flowabs_nodes.run(
            graph, frames=self.frames, existing=self.existing, scale=self.scale, on_event=background.hear
        )

    def _files(self, graph: RunnableGraph) -> dict[str, str]:
        """Return the file that each write node is set to."""
        writes = sinks(graph)
        values = graph.values(1)
        unset = [name for name in writes if not values[name].get("file") or len(writes) == 1]
        first = Path(self.output)
        return {
            f"{name}.file": str(first.with_name(f"{name}.{first.name}") if number else first)
            for number, name in enumerate(unset)
        }
