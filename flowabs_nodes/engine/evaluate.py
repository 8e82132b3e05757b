"""Computes the steps of a plan in order, each result held until its last use."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np

from flowabs_nodes import stopping
from flowabs_nodes.encodings import remember_encodings
from flowabs_nodes.engine.call_node import call_node, call_sink, check_params
from flowabs_nodes.engine.error_boundary import error_boundary
from flowabs_nodes.engine.lengths import length_factor, scale_lengths
from flowabs_nodes.engine.plan import Result, Step, Unit, results_in
from flowabs_nodes.engine.report import Note
from flowabs_nodes.engine.resize import scale_image
from flowabs_nodes.engine.stopwatch import Stopwatch
from flowabs_nodes.engine.unit_params import Params
from flowabs_nodes.engine.window_inputs import NodeInputs, own_frame
from flowabs_nodes.finishing.deferred import Deferred
from flowabs_nodes.image import Image
from flowabs_nodes.io.shared_decode import shared_decodes
from flowabs_nodes.nodes.declare import Context, Node
from flowabs_nodes.port_types import pixel_type
from flowabs_nodes.simd.known_finite import remember_finite

if TYPE_CHECKING:
    from flowabs_nodes.engine.options import RunOptions
    from flowabs_nodes.graph.model import Graph
    from flowabs_nodes.io.sequences import Source

#: The nodes that read pictures by this package's own readers, which share what they decode.
_READERS = frozenset({"read", "read_aov", "read_depth", "read_normal", "read_motion", "read_id"})


@dataclass
class Evaluation:
    """The computation of one frame, for which nodes may run on other frames too.

    ``notes`` and the timings of the ``stopwatch`` fill up, also when a node fails.

    Attributes
    ----------
    params
        Each unit's parameters, lengths not scaled.
    sources
        For each unit that reads a file, which file that is on this frame.
    options
        The run's options, of which ``scale`` and ``settings`` matter here.
    on_sink
        Called with the name of a node without outputs (``write``) and what its function returned, as soon as it has
        run.
    on_result
        Called with each result and its image as soon as it is computed.
    """

    graph: Graph
    params: Mapping[Unit, Params]
    sources: Mapping[Unit, Source]
    options: RunOptions
    on_sink: Callable[[str, Any], None] = lambda node, what: None
    on_result: Callable[[Result, Image], None] = lambda result, image: None
    notes: list[Note] = field(default_factory=list)
    stopwatch: Stopwatch = field(default_factory=Stopwatch)

    def run(
        self, steps: Collection[Step], given: Mapping[Result, Image], keep: Collection[Result] = ()
    ) -> dict[Result, Image]:
        """Run all steps in order, each result held until its last use.

        Parameters
        ----------
        given
            Images that stand in for results that no step computes.
        keep
            The results to return, decoded; all others are let go.

        Raises
        ------
        FlowabsError
            Whatever went wrong, with node and frame.
        Stopped
            The work was asked to stop.
        """
        held, expected = dict(given), self._expected(steps)
        maker: WeakKeyDictionary[Image, Result] = WeakKeyDictionary()
        with remember_finite(), shared_decodes(self._readers(steps)), remember_encodings() as encodings:
            encodings.decoding = partial(self._decoding, maker)
            for result, image in held.items():
                maker[image] = result
                encodings.expect(image, expected.get(result, frozenset()))
            for step in steps:
                stopping.check()
                images: NodeInputs = {
                    name: held[needed]
                    if isinstance(needed, Result)
                    else {offset: held[result] for offset, result in needed.items()}
                    for name, needed in step.inputs.items()
                }
                for result in step.needs:
                    encodings.keep(held[result], result not in step.drops)
                with self.stopwatch.of(*step.unit):
                    outputs = self._run_step(step, images)
                for output, image in outputs.items():
                    result = Result(step.unit.node, output, step.unit.frame)
                    held[result] = image
                    maker.setdefault(image, result)  # a node may hand on its input
                    encodings.expect(image, expected.get(result, frozenset()))
                    self.on_result(result, image)
                for result in step.drops:
                    held.pop(result, None)
                del images, outputs
            return {result: self._decoded(result, given.get(result) or held[result]) for result in keep}

    def _decoded(self, result: Result, image: Image) -> Image:
        """Return a result as it leaves the engine, with pixels in place of code values."""
        with error_boundary(result.node, result.frame):
            return image.decoded()

    def _decoding(self, maker: Mapping[Image, Result], image: Image) -> AbstractContextManager[None]:
        """Take the time of decoding an image inside, under the name of the node that left it undecoded.

        Whoever asks for its pixels may be another node; and what was noted down on the way is done with the decoding.
        """
        result = maker.get(image)
        work = "finishing" if isinstance(image.deferred, Deferred) else "decoding"
        return self.stopwatch.of(f"({work} {result.node})" if result else f"({work})", result.frame if result else 0)

    def _expected(self, steps: Collection[Step]) -> dict[Result, frozenset[str]]:
        """Return, for each picture, the spaces in which later steps smooth it."""
        spaces: dict[Result, set[str]] = {}
        for step in steps:
            space = self.params[step.unit].get("space")
            if space is not None and "image" in step.inputs and self.graph.nodes[step.unit.node].declaration.mixes:
                for result in results_in({"image": step.inputs["image"]}):
                    spaces.setdefault(result, set()).add(space)
        return {result: frozenset(each) for result, each in spaces.items()}

    def _readers(self, steps: Collection[Step]) -> dict[str, list[Callable[[], object]]]:
        """Return, by the path of each file, what reads it in these steps: functions without inputs or notes."""
        readers: dict[str, list[Callable[[], object]]] = {}
        for step in steps:
            declaration = self.graph.nodes[step.unit.node].declaration
            if step.unit in self.sources and declaration.type in _READERS:
                readers.setdefault(str(self.sources[step.unit].path), []).append(partial(self._read, step, declaration))
        return readers

    def _read(self, step: Step, declaration: Node) -> object:
        """Call a node that reads a file as :meth:`_run_step` does, with nobody to tell anything."""
        assert declaration.file_param is not None
        params = dict(self.params[step.unit]) | {declaration.file_param.name: str(self.sources[step.unit].path)}
        context = Context(step.unit.frame, step.unit.node, step.wanted, services=self.options.settings)
        return declaration.run(context, **check_params(declaration, params))

    def _run_step(self, step: Step, images: NodeInputs) -> dict[str, Image]:
        """Run one step on its inputs and return its outputs by name; what a read node returns is scaled."""
        node, frame = step.unit
        declaration = self.graph.nodes[node].declaration
        context = Context(
            frame=frame,
            node=node,
            wanted=step.wanted,
            note=partial(self._note, step.unit, False),
            warn=partial(self._note, step.unit, True),
            services=self.options.settings,
        )
        with error_boundary(node, frame):
            params = self._params(step, declaration, images)
            if not declaration.outputs:
                self.on_sink(node, call_sink(declaration, context, images, params))
                return {}
            outputs = call_node(declaration, context, images, params)
            source = self.sources.get(step.unit)
            if source is None:
                return outputs
            return {
                name: scale_image(_black(image) if source.black else image, self.options.scale)
                for name, image in outputs.items()
            }

    def _params(self, step: Step, declaration: Node, images: NodeInputs) -> dict[str, Any]:
        """Return the step's parameters with lengths scaled to the picture it looks at, and the file of this frame."""
        params = dict(self.params[step.unit])
        if step.unit in self.sources and declaration.file_param:
            params[declaration.file_param.name] = str(self.sources[step.unit].path)
        looks_at = next((own_frame(images[name]) for name in declaration.all_inputs if name in images), None)
        factor = length_factor(self.graph.reference_size, self.options.scale, looks_at)
        params, warnings = scale_lengths(declaration, params, factor, self.options.scale)
        self.notes.extend(replace(warning, node=step.unit.node, frame=step.unit.frame) for warning in warnings)
        return params

    def _note(self, unit: Unit, warning: bool, text: str) -> None:
        """Add what a node has to say about its frame to the notes."""
        self.notes.append(Note(text, unit.node, warning, frame=unit.frame))


def _black(image: Image) -> Image:
    """Return a frame of nothing (black, no id, depth far away) with the windows and metadata of ``image``.

    It has no origin, so that ``write`` keeps no layer of the frame that it was made from.
    """
    return Image(
        np.full_like(image.pixels, pixel_type(image.type).outside), image.spec, image.type, colorspace=image.colorspace
    )
