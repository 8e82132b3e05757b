"""Carries results from one frame of a run to those that follow: whatever their windows of frames will ask for.

A run of a graph in which no node reads other frames carries nothing.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING

from flowabs_nodes.engine.plan import Inputs, Result, Step, Unit, results_in, sinks, unit_inputs
from flowabs_nodes.engine.result_store import ResultStore, StoredKey
from flowabs_nodes.engine.unit_params import UnitParams, needed_inputs, unit_offsets
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.frame_offsets import MAX_DISTANCE

if TYPE_CHECKING:
    from flowabs_nodes.graph.model import Graph


class CarryOver:
    """Holds results between the frames of a run, in ``store``; ``frames`` are the numbers of all frames to render."""

    def __init__(self, graph: Graph, frames: Iterable[int], store: ResultStore) -> None:
        self._store = store
        self._lookahead = Lookahead(graph, frames)
        self._stored: dict[Result, StoredKey] = {}  # what was put into the store, though it may be out of it again
        self._to_keep: dict[Result, StoredKey] = {}

    @property
    def _idle(self) -> bool:
        """Whether nothing is ever carried over."""
        return not (self._lookahead.reads_other_frames or self._store.keeps_all)

    def begin(self, frame: int) -> None:
        """Note that a frame is being rendered: it is no longer one that follows."""
        self._lookahead.to_come.discard(frame)

    def held(self, steps: Iterable[Step], keys: Mapping[Unit, str]) -> dict[Result, Image]:
        """Return the results of a plan that need not be computed, because they are in the store."""
        if self._idle:
            return {}
        names = {result: _stored_key(result, keys) for step in steps for result in step.makes}
        images = {result: self._store.get(name) for result, name in names.items()}
        return {result: image for result, image in images.items() if image is not None}

    def choose(self, steps: Iterable[Step], keys: Mapping[Unit, str]) -> None:
        """Choose what is kept for frames that follow: of the store, and of what ``steps``, about to run, compute."""
        if self._idle:
            return
        self._to_keep = {result: name for result, name in self._stored.items() if name in self._store}
        self._to_keep |= {result: _stored_key(result, keys) for step in steps for result in step.makes}
        if not self._store.keeps_all:
            asked_for = self._lookahead.asked_for(self._to_keep)
            self._to_keep = {result: name for result, name in self._to_keep.items() if result in asked_for}
            self._store.keep_only(set(self._to_keep.values()))

    def put(self, result: Result, image: Image) -> None:
        """Hold an image that has just been computed, if it was chosen."""
        name = self._to_keep.get(result)
        if name is not None:
            self._store.put(name, image)
            self._stored[result] = name


def _stored_key(result: Result, keys: Mapping[Unit, str]) -> StoredKey:
    """Return the name of a result in the store."""
    return StoredKey(keys[result.unit], result.output, result.frame)


class Lookahead:
    """Says which results the frames ``to_come``, a set that the caller empties, will ask for."""

    def __init__(self, graph: Graph, frames: Iterable[int]) -> None:
        self.to_come = set(frames)
        self._graph = graph
        self._sinks = sinks(graph)
        self._windowed = [name for name, node in graph.nodes.items() if node.declaration.frames is not None]
        self._offsets: dict[Unit, dict[str, tuple[int, ...]]] = {}  # of the units that were looked at last

    @property
    def reads_other_frames(self) -> bool:
        """Whether any node of the graph reads other frames."""
        return bool(self._windowed)

    def asked_for(self, held: Collection[Result]) -> set[Result]:
        """Return the results among ``held`` that the frames to come will read, if none but these are there already.

        A result that is only needed to compute another one that is held is not among them.
        """
        asked: set[Result] = set()
        seen: set[Unit] = set()
        stack = [Unit(sink, frame) for frame in self._near({result.frame for result in held}) for sink in self._sinks]
        while stack:
            unit = stack.pop()
            if unit in seen:
                continue
            seen.add(unit)
            for result in results_in(self._inputs_of(unit)):
                if result in held:
                    asked.add(result)
                else:
                    stack.append(result.unit)
        self._offsets = {unit: offsets for unit, offsets in self._offsets.items() if unit in seen}
        return asked

    def _near(self, frames: set[int]) -> set[int]:
        """Return the frames to come that may ask for a result of one of ``frames``."""
        reach = MAX_DISTANCE * len(self._windowed)  # offsets add up along a chain of nodes
        return {near for frame in frames for near in range(frame - reach, frame + reach + 1) if near in self.to_come}

    def _inputs_of(self, unit: Unit) -> Inputs:
        """Return what a unit asks for, whether it is there or not; its own frame alone, where it cannot say."""
        if self._graph.nodes[unit.node].declaration.needs is not None:
            return self._inputs_chosen(unit)
        if unit.node not in self._windowed:
            return unit_inputs(self._graph, unit)
        if unit not in self._offsets:
            try:
                self._offsets[unit] = unit_offsets(self._graph, unit, UnitParams(self._graph))
            except FlowabsError:  # raised again, and told, when the frame is rendered
                self._offsets[unit] = {}
        return unit_inputs(self._graph, unit, self._offsets[unit])

    def _inputs_chosen(self, unit: Unit) -> Inputs:
        """Return what a unit that chooses its inputs asks for on its frame; all, where it cannot say."""
        params = UnitParams(self._graph)
        try:
            needed = needed_inputs(self._graph, unit, params)
            return unit_inputs(self._graph, unit, unit_offsets(self._graph, unit, params), needed)
        except FlowabsError:  # raised again, and told, when the frame is rendered
            return unit_inputs(self._graph, unit)
