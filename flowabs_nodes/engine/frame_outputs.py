"""Computes outputs of one frame, images in and images out: what :meth:`RunnableGraph.run` and a session share."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING

from flowabs_nodes.color.config import opened
from flowabs_nodes.engine.evaluate import Evaluation
from flowabs_nodes.engine.frame_windows import FrameWindows
from flowabs_nodes.engine.keys import unit_keys
from flowabs_nodes.engine.plan import Result, Step, Unit, make_plan, named_result
from flowabs_nodes.engine.sources import Sources, source_contents
from flowabs_nodes.engine.stopwatch import Stopwatch
from flowabs_nodes.engine.unit_params import UnitParams
from flowabs_nodes.errors import CommandError
from flowabs_nodes.graph.missing_packages import refuse_missing_packages

if TYPE_CHECKING:
    from flowabs_nodes.engine.options import RunOptions
    from flowabs_nodes.engine.report import Note
    from flowabs_nodes.graph.model import Graph
    from flowabs_nodes.image import Image


class FrameOutputs:
    """Plans the outputs ``names`` of a graph on one frame, and computes them. Nothing is written.

    ``given`` are the images that stand in for results, already made smaller by ``options.scale``.

    Raises
    ------
    CommandError
        A name does not exist, a file to read is not set, or it is missing and missing frames are skipped.
    GraphError
        A node that is to run needs a package that is not installed.
    FlowabsError
        A file is missing, or no picture; with node and frame.
    """

    def __init__(
        self, graph: Graph, frame: int, names: Iterable[str], given: Mapping[Result, Image], options: RunOptions
    ) -> None:
        self.wanted = {name: named_result(graph, name, frame) for name in names}
        self._graph, self._frame, self._given, self._options = graph, frame, given, options
        self._params = UnitParams(graph)
        found = Sources(graph, self._params, options)
        self._inputs_of = FrameWindows(graph, self._params, found, given).inputs_of
        self.steps = self._plan(given)
        refuse_missing_packages(graph, {step.unit.node for step in self.steps})
        try:
            self._sources = found.of_steps(self.steps)
        except CommandError as error:
            if error.code == "file-not-set":
                error.hint = self._half_given(error.node) or error.hint
            raise
        for unit, source in self._sources.items():
            if source.skip:
                raise CommandError("no such file, and missing frames are skipped", code="missing-file", node=unit.node)

    def keys(self, given: Mapping[Result, str]) -> dict[Unit, str]:
        """Return the key of every step's unit; ``given`` are the keys of the images that stand in for results."""
        return unit_keys(
            self._graph,
            self.steps,
            self._params,
            contents=source_contents(self._sources),
            given=given,
            scale=self._options.scale,
            ocio=opened(self._options.ocio).content,
        )

    def leave_out(self, held: Mapping[Result, Image]) -> None:
        """Take results that are there already as they are, with all that only they need."""
        self._given = {**self._given, **held}
        self.steps = self._plan(self._given)

    def compute(
        self,
        notes: list[Note],
        stopwatch: Stopwatch | None = None,
        on_result: Callable[[Result, Image], None] = lambda result, image: None,
    ) -> dict[str, Image]:
        """Return an image for each name. ``notes`` fills up, also when a node fails.

        Raises
        ------
        FlowabsError
            Whatever went wrong, with node and frame.
        Stopped
            The work was asked to stop.
        """
        evaluation = Evaluation(
            self._graph,
            self._params,
            self._sources,
            self._options,
            on_result=on_result,
            notes=notes,
            stopwatch=stopwatch or Stopwatch(),
        )
        results = evaluation.run(self.steps, self._given, keep=self.wanted.values())
        return {name: results[result] for name, result in self.wanted.items()}

    def _half_given(self, node: str | None) -> str:
        """Return a hint for a node that would read a file, where some of its outputs are given and others are not."""
        outputs = [] if node is None else list(self._graph.nodes[node].declaration.all_outputs)
        there = [name for name in outputs if any((each.node, each.output) == (node, name) for each in self._given)]
        others = [f"'{node}.{name}'" for name in outputs if name not in there]
        return f"its {', '.join(there)} is given, but not {', '.join(others)}" if there and others else ""

    def _plan(self, given: Mapping[Result, Image]) -> tuple[Step, ...]:
        """Return the steps that compute what is wanted where ``given`` is there."""
        return make_plan(self._graph, self._frame, results=self.wanted.values(), given=given, inputs_of=self._inputs_of)
