"""Says which frames each unit reads, and which of these are there: a window of frames ends where the sequence does."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flowabs_nodes.engine.plan import Inputs, Result, Unit, file_role, unit_inputs
from flowabs_nodes.engine.sources import Sources
from flowabs_nodes.engine.unit_params import Params, chooses_inputs, needed_inputs, unit_offsets
from flowabs_nodes.errors import ReadError

if TYPE_CHECKING:
    from flowabs_nodes.graph.model import Graph


@dataclass(frozen=True)
class Feeds:
    """Where an output's pictures come from in the end: the nodes upstream that read, and the outputs that are given."""

    reads: tuple[str, ...]
    given: tuple[tuple[str, str], ...]


class FrameWindows:
    """Says what each unit of a graph reads, on its own frame and on others.

    A node's own frame counts as there: what to do about a file that it lacks is up to the caller. A frame before or
    after it is there if

    - it lies between the ends of the sequence: the first and the last frame on disk of all sequences upstream of the
      input, whichever frames are rendered. A single picture, without a frame number, is on no frame but the node's own;
    - every read upstream has a picture there: its file, or what its policy ``missing`` puts in place of a hole. With
      ``skip`` the frame is not there, with ``error`` it is an error. Where several sequences end at different frames,
      a frame beyond the ends of one whose policy finds no picture is not there, and no error;
    - every output upstream that is ``given`` is given on that frame.

    What neither comes from a file nor is given, such as noise, is on every frame.
    """

    def __init__(
        self, graph: Graph, params: Mapping[Unit, Params], sources: Sources, given: Collection[Result] = ()
    ) -> None:
        self._graph = graph
        self._params = params
        self._sources = sources
        self._given: dict[tuple[str, str], set[int]] = {}  # the frames by (node, output)
        for node, output, frame in given:
            self._given.setdefault((node, output), set()).add(frame)
        self._chooses = chooses_inputs(graph)
        self._feeds: dict[tuple[str, str, int | None], Feeds] = {}  # of any frame, unless nodes choose their inputs
        self._spans: dict[Feeds, range] = {}

    def inputs_of(self, unit: Unit) -> Inputs:
        """Return what a unit reads; of an input that is read on several frames, those that are there.

        Raises
        ------
        FlowabsError
            With the node and the frame: the node's ``frames`` breaks a rule, or the file of another frame is missing.
        """
        offsets = unit_offsets(self._graph, unit, self._params)
        inputs = unit_inputs(self._graph, unit, offsets, needed_inputs(self._graph, unit, self._params))
        for name, window in inputs.items():
            if name in offsets:
                inputs[name] = {each: result for each, result in window.items() if each == 0 or self._is_there(result)}
        return inputs

    def _is_there(self, result: Result) -> bool:
        """Return whether a result exists on its frame, as the frame before or after another one."""
        frame = result.frame
        feeds = self._feeds_of(result)
        if not feeds.reads and not feeds.given:
            return True
        if not all(frame in self._given[each] for each in feeds.given):
            return False
        if frame not in self._span_of(feeds, frame):
            return False
        # Of all reads, so that an error in any is raised.
        have_pictures = [self._has_picture(Unit(read, frame)) for read in feeds.reads]
        return all(have_pictures)

    def _span_of(self, feeds: Feeds, frame: int) -> range:
        """Return the frames from the first to the last that any sequence has; none where there is no sequence.

        It is the same for every ``frame``.
        """
        if feeds not in self._spans:
            frames = {each for read in feeds.reads for each in self._sources.frames_on_disk(Unit(read, frame))}
            frames.update(*(self._given[each] for each in feeds.given))
            self._spans[feeds] = range(min(frames), max(frames) + 1) if frames else range(0)
        return self._spans[feeds]

    def _has_picture(self, unit: Unit) -> bool:
        """Return whether a unit that reads has a picture to read, be it of another frame."""
        try:
            return not self._sources.of(unit).skip
        except ReadError as error:
            own = self._sources.frames_on_disk(unit)
            if error.code == "missing-file" and own and not own[0] <= unit.frame <= own[-1]:
                return False
            raise

    def _feeds_of(self, result: Result) -> Feeds:
        """Return where the pictures of a result come from."""
        frame = result.frame
        key = (result.node, result.output, frame if self._chooses else None)
        if key not in self._feeds:
            reads: dict[str, None] = {}
            given: dict[tuple[str, str], None] = {}
            seen = set()
            stack = [(result.node, result.output)]
            while stack:
                each = stack.pop()
                if each in self._given:
                    given[each] = None
                elif each[0] not in seen:
                    seen.add(each[0])
                    if file_role(self._graph, each[0]) == "input":
                        reads[each[0]] = None
                    unit = Unit(each[0], frame)
                    inputs = unit_inputs(self._graph, unit, needed=needed_inputs(self._graph, unit, self._params))
                    stack.extend((needed.node, needed.output) for needed in inputs.values())
            self._feeds[key] = Feeds(tuple(reads), tuple(given))
        return self._feeds[key]
