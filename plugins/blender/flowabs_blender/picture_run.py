"""Runs a graph on one picture, in any thread: images come out, and on disk an EXR."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flowabs_nodes import Image, Session, load_graph
from flowabs_nodes.engine.runnable import GraphSource
from flowabs_nodes.graph.model import Graph
from flowabs_nodes.io.write import build_picture, save

from .background import Background
from .outputs import main_outputs, writer_of
from .plates import with_picture
from .taken import Taken


@dataclass(frozen=True)
class PictureRun:
    """What to run on which picture; calling it does the work.

    Attributes
    ----------
    graph
        A document, a path, or the name of a graph that comes with flowabs.
    picture
        What stands for the graph's plate; a Path is read as ``flowabs run -i`` reads it.
    outputs
        The outputs to compute, "node" or "node.output"; none: the images that the graph writes, without layers.
    frame, scale, values
        As :meth:`flowabs_nodes.RunnableGraph.run` takes them; ``values`` are its ``set``.
    file
        The EXR to write, encoded and with layers as the graph's write node says; of several outputs, each further one
        has its name in the file's.
    """

    graph: GraphSource
    picture: Image | Taken | Path
    outputs: tuple[str, ...] = ()
    frame: int = 1
    scale: float = 1.0
    values: Mapping[str, Any] | None = None
    file: Path | None = None

    def __call__(self, background: Background[dict[str, Image]]) -> dict[str, Image]:
        """Return an image for each output. Raises FlowabsError for whatever is wrong."""
        graph = load_graph(self.graph)
        names = self.outputs or main_outputs(graph)
        graph, given = with_picture(graph.with_set(self.values) if self.values else graph, self.picture)
        layers = {name: _layers(graph, name) for name in names} if self.file is not None else {}
        wanted = dict.fromkeys([*names, *(each for found in layers.values() for each in found.values())])
        with Session(graph, on_event=background.hear) as session:
            session.given(given)
            made = session.run(wanted, self.frame, self.scale)
        for number, name in enumerate(names if self.file is not None else ()):
            file = self.file if number == 0 else self.file.with_suffix(f".{name}{self.file.suffix}")
            background.text = f"writes {file.name}"
            beside = {key: made[each] for key, each in layers[name].items()}
            picture = build_picture(made[name], beside, warn=background.warn, **_encoding(graph, name, self.frame))
            save(picture, file, graph=json.dumps(graph.document), scale=self.scale, warn=background.warn)
        return {name: made[name].decoded() for name in names}


def _layers(graph: Graph, output: str) -> dict[str, str]:
    """Return the further layers that are written beside an output, by their names."""
    sink = writer_of(graph, output)
    links = graph.nodes[sink].inputs if sink is not None else {}
    return {name: f"{link.node}.{link.output}" for name, link in links.items() if name != "image"}


def _encoding(graph: Graph, output: str, frame: int) -> dict[str, Any]:
    """Return how the node encodes an output that writes it; nothing where none does."""
    sink = writer_of(graph, output)
    values = graph.values(frame)[sink] if sink is not None else {}
    return {name: value for name, value in values.items() if name != "file"}
