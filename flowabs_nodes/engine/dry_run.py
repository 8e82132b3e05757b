"""Tells what a run would read, write and do, from names, times and headers alone; nothing is made, not even a folder.

No plate is opened. Whether a file that is there carries the key of this run is therefore not known: that takes the
content of all plates. It is known who made it (the stamp in its header) and whether a plate is newer than it.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, Literal

from flowabs_nodes import stopping
from flowabs_nodes.engine.error_boundary import error_boundary
from flowabs_nodes.engine.existing import Origin, exists, foreign, not_ours
from flowabs_nodes.engine.frame_windows import FrameWindows
from flowabs_nodes.engine.job import Job
from flowabs_nodes.engine.job_builder import build_job
from flowabs_nodes.engine.ocio_choice import choose_config
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.engine.plan import file_role, make_plan
from flowabs_nodes.engine.runnable import GraphSource, load_graph
from flowabs_nodes.engine.sources import Sources, file_of
from flowabs_nodes.engine.unit_params import UnitParams, chooses_inputs, inputs_on_any_frame
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.graph.values import Curve
from flowabs_nodes.io.provenance import stored_stamp
from flowabs_nodes.io.sequences import Sequence, Source
from flowabs_nodes.io.settings import checked
from flowabs_nodes.io.write_failure import check_replaceable

State = Literal["make", "there", "newer", "other", "left-out", "fail"]

#: What each state of a frame means, for people.
MEANINGS: Mapping[State, str] = {
    "make": "to make",
    "there": "there, of this graph and scale: kept if its parameters and plates are the same",
    "newer": "there, but a plate is newer: made again if a plate's content or a parameter has changed",
    "other": "there, of another graph or scale: fails unless the picture is the very same",
    "left-out": "left out: the plate is missing",
    "fail": "will fail",
}

#: What a dry run does not look at.
NOT_KNOWN = (
    "From names, times and headers alone: whether plates can be read, whether a file that is there is whole and of the"
    " same parameters and plates, and what other runs are writing, only a run finds out."
)


@dataclass(frozen=True)
class FramePlan:
    """What a run would do on one frame: the files that it would read and write, and why it would fail."""

    frame: int
    state: State
    reads: tuple[str, ...] = ()
    writes: tuple[str, ...] = ()
    error: FlowabsError | None = None

    def event(self) -> dict[str, Any]:
        """Return the frame as plain data, for ``--json``."""
        return {
            "event": "dry-run-frame",
            "frame": self.frame,
            "state": self.state,
            "reads": list(self.reads),
            "writes": list(self.writes),
            "error": self.error.to_dict() if self.error else None,
        }


@dataclass(frozen=True)
class DryRun:
    """What a run would do: the graph's name, the patterns that it reads and writes, and its frames, planned one by one.

    ``plans`` is read once. Its frames are in the order in which a run would begin them.
    """

    graph: str
    frames: tuple[int, ...]
    reads: tuple[str, ...]
    writes: tuple[str, ...]
    plans: Iterator[FramePlan]


def dry_run(graph: GraphSource, options: RunOptions) -> DryRun:
    """Plan a run. Raises what a run raises before its first frame: GraphError, CommandError, ColorError."""
    loaded = load_graph(graph)
    if options.set:
        loaded = loaded.with_set(options.set)
    options, _ = choose_config(options)
    job, numbers = build_job(loaded, options, touch=False)
    values = job.graph.values(1)
    reads = dict.fromkeys(_pattern(job, node, values) for node in _readers(job))
    writes = tuple(pattern for patterns in job.outputs.values() for pattern in patterns)
    return DryRun(loaded.name, numbers, tuple(reads), writes, _plans(job, numbers, tuple(map(Sequence, writes))))


def _plans(job: Job, numbers: tuple[int, ...], outputs: tuple[Sequence, ...]) -> Iterator[FramePlan]:
    """Yield what a run would do on each frame."""
    sources_of = _sources_of(job)
    for frame in numbers:
        stopping.check()
        yield _plan(job, frame, tuple(sequence.path(frame) for sequence in outputs), sources_of)


def _plan(job: Job, frame: int, writes: tuple[str, ...], sources_of: Callable[[int], list[Source]]) -> FramePlan:
    """Return what a run would do on one frame."""
    reads: tuple[str, ...] = ()
    try:
        with error_boundary(frame=frame):
            sources = sources_of(frame)
            if any(source.skip for source in sources):
                return FramePlan(frame, "left-out")
            reads = tuple(dict.fromkeys(source.path for source in sources if source.path is not None))
            return FramePlan(frame, _state(job, writes, reads), reads, writes)
    except FlowabsError as error:
        return FramePlan(frame, "fail", reads, writes, error)


def _state(job: Job, writes: tuple[str, ...], reads: tuple[str, ...]) -> State:
    """Return what a run would do with the files of a frame. Raises WriteError where one is surely in the way."""
    origin = Origin(job.graph.name, job.options.scale)
    states = {_state_of(path, origin, job.options.existing) for path in writes}
    if "other" in states or "make" in states:
        return "other" if "other" in states else "make"
    oldest = min(_changed(path) for path in writes)
    return "newer" if any(_changed(path) > oldest for path in reads) else "there"


def _state_of(path: str, origin: Origin, existing: str) -> Literal["make", "there", "other"]:
    """Return what a run would do with a file. Raises WriteError where it is surely in the way."""
    if not os.path.lexists(path):
        return "make"
    check_replaceable(path)
    if existing == "overwrite":
        return "make"
    if existing == "error":
        raise exists(path)
    found = stored_stamp(path)
    why = foreign(found, origin)
    if why and (found is None or not found.key):
        raise not_ours(path, why)
    return "other" if why else "there"


def _changed(path: str) -> int:
    """Return when a file was changed, in ns; 0 where that cannot be told."""
    try:
        return os.stat(path).st_mtime_ns
    except OSError:
        return 0


# ---------------------------------------------------------------------- what a frame reads


def _sources_of(job: Job) -> Callable[[int], list[Source]]:
    """Return a function from a frame to the sources of all that it reads.

    Where no parameter moves and no node looks at other frames, every frame is planned as the first is.
    """
    graph = job.graph
    moves = any(isinstance(value, Curve) for node in graph.nodes.values() for value in node.params.values())
    moves |= any(knob.curve is not None for knob in graph.interface.values())
    if moves or chooses_inputs(graph) or any(each.declaration.frames is not None for each in graph.nodes.values()):
        return partial(_planned_sources, job)
    values = graph.values(1)
    sequences = {node: Sequence.to_read(_pattern(job, node, values)) for node in _readers(job)}
    policies = {node: job.options.missing or values[node].get("missing", "error") for node in sequences}
    on_disk = cache(lambda node: sequences[node].frames_on_disk())

    def sources_of(frame: int) -> list[Source]:
        found = []
        for node, sequence in sequences.items():
            with error_boundary(node, frame):
                listed = on_disk(node) if policies[node] != "error" else None
                source = sequence.resolve(frame, policies[node], listed)
                if source.path is not None and job.options.root is not None:
                    checked(source.path, job.options.settings)
                found.append(source)
        return found

    return sources_of


def _planned_sources(job: Job, frame: int) -> list[Source]:
    """Return the sources of all that a frame reads, planned on its own."""
    params = UnitParams(job.graph)
    found = Sources(job.graph, params, job.options, open_files=False)
    inputs_of = FrameWindows(job.graph, params, found).inputs_of
    steps = make_plan(job.graph, frame, sinks=job.outputs, inputs_of=inputs_of)
    return list(found.of_steps(steps).values())


def _readers(job: Job) -> list[str]:
    """Return the nodes that read a file on any frame."""
    needs = partial(inputs_on_any_frame, job.graph, params=UnitParams(job.graph))
    steps = make_plan(job.graph, 1, sinks=job.outputs, inputs_of=needs)
    return [step.unit.node for step in steps if file_role(job.graph, step.unit.node) == "input"]


def _pattern(job: Job, node: str, values: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the file or pattern that a node reads, of the parameters of all nodes."""
    return file_of(job.graph, node, values[node])
