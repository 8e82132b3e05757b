"""A graph that can be run from Python, image in and image out, without any file being written."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, cast

from flowabs_nodes import graph as graphs
from flowabs_nodes.engine.evaluate import Evaluation
from flowabs_nodes.engine.lengths import check_scale
from flowabs_nodes.engine.plan import Result, Unit, make_plan, named_result, sinks
from flowabs_nodes.engine.report import Listener, Note, note_event
from flowabs_nodes.engine.resize import scale_image
from flowabs_nodes.engine.sources import find_sources
from flowabs_nodes.errors import ArgumentError, CommandError
from flowabs_nodes.graph.model import Graph
from flowabs_nodes.image import Image, PortType
from flowabs_nodes.io.settings import Settings

log = logging.getLogger("flowabs")


class RunnableGraph(Graph):
    """A :class:`~flowabs_nodes.graph.model.Graph` with :meth:`run`."""

    def run(
        self,
        frame: int = 1,
        given: Mapping[str, Image] | None = None,
        set: Mapping[str, Any] | None = None,
        outputs: Iterable[str] | None = None,
        scale: float = 1.0,
        settings: Settings | None = None,
        on_event: Listener | None = None,
    ) -> dict[str, Image]:
        """Compute images of one frame.

        Parameters
        ----------
        given
            Images that stand in for outputs, by ``"node"`` (its first output) or ``"node.output"``. What only they
            would have needed, files included, is not touched.
        set
            Values of knobs and parameters: ``{"line_width": 1.5, "lines.softness": 2}``.
        outputs
            What to compute, named as in ``given``. Without it: what goes into the graph's ``write`` nodes.
        scale
            Above 0 up to 1: makes the pictures that come in smaller, and pixel lengths with them.
        on_event
            Gets a dict for each note and warning; without it they go to the logger "flowabs".

        Returns
        -------
        dict
            An Image for each name in ``outputs``. Nothing is written.

        Raises
        ------
        GraphError
            For wrong values in ``set``.
        CommandError
            For names that do not exist (with the nearest), and where a file to read is neither set nor its image given.
        FlowabsError
            Whatever went wrong while computing, with node and frame.
        """
        graph = self.with_set(set) if set else self
        scale, settings = check_scale(scale), settings or Settings()
        images = {result: scale_image(image, scale) for result, image in _given(graph, given or {}, frame).items()}
        names = tuple(outputs) if outputs is not None else _written(graph)
        wanted = {name: named_result(graph, name, frame) for name in names}
        steps = make_plan(graph, frame, results=wanted.values(), given=images)
        params = {Unit(node, frame): values for node, values in graph.values(frame).items()}
        sources = find_sources(graph, steps, params, missing=None, settings=settings)
        left_out = next((unit for unit, source in sources.items() if source.skip), None)
        if left_out is not None:
            raise CommandError("no such file, and missing frames are skipped", code="missing-file", node=left_out.node)
        evaluation = Evaluation(graph, params, sources, settings, scale)
        try:
            results = evaluation.run(steps, images, keep=wanted.values())
        finally:
            _tell(evaluation.notes, frame, on_event)
        return {name: results[result] for name, result in wanted.items()}

    def with_set(self, values: Mapping[str, Any]) -> RunnableGraph:
        """The graph with other values of knobs and parameters; GraphError names each that is wrong."""
        return _runnable(graphs.override(self, values))


def load_graph(source: str | Path | Mapping[str, Any] | Graph) -> RunnableGraph:
    """A graph from a file, the name of one that comes with the package, or its content as a dict.

    Raises
    ------
    GraphError
        With every problem of the graph in ``problems``.
    """
    return _runnable(source if isinstance(source, Graph) else graphs.load(source))


def _runnable(graph: Graph) -> RunnableGraph:
    if isinstance(graph, RunnableGraph):
        return graph
    return RunnableGraph(**{field.name: getattr(graph, field.name) for field in fields(graph)})


def _given(graph: Graph, given: Mapping[str, Image], frame: int) -> dict[Result, Image]:
    """Images by the result they stand in for, each of a type that the output may have."""
    images: dict[Result, Image] = {}
    for name, image in given.items():
        result = named_result(graph, name, frame)
        if not isinstance(image, Image):
            raise ArgumentError(
                f"given[{name!r}]: expected an Image, found {type(image).__name__}",
                code="wrong-type",
                hint="Image.from_array and Image.from_imagebuf make one",
                parameter="given",
            )
        if result in images:
            raise ArgumentError(f"given[{name!r}]: this output is given twice", parameter="given")
        port = graph.nodes[result.node].declaration.all_outputs[result.output]
        kind = image.type if port.same_as else port.takes(image.type)
        if kind is None:
            raise ArgumentError(
                f"given[{name!r}]: expected {port.types.replace('|', ' or ')}, found {image.type}",
                code="wrong-type",
                parameter="given",
            )
        images[result] = image.as_type(cast(PortType, kind))
    return images


def _written(graph: Graph) -> tuple[str, ...]:
    """The names of all that goes into the graph's write nodes."""
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


def _tell(notes: Iterable[Note], frame: int, on_event: Listener | None) -> None:
    for note in notes:
        if on_event is not None:
            on_event(note_event(note, frame))
        else:
            log.log(logging.WARNING if note.warning else logging.INFO, "frame %d: %s", frame, note)
