"""Renders one frame of a run: finds its files, sees which results are there already, computes and writes the others."""

from __future__ import annotations

import json
import os
import time
import traceback
from contextlib import ExitStack
from typing import Any

from flowabs_nodes.engine.carry_over import CarryOver
from flowabs_nodes.engine.error_boundary import error_boundary
from flowabs_nodes.engine.evaluate import Evaluation
from flowabs_nodes.engine.frame_windows import FrameWindows
from flowabs_nodes.engine.job import Job
from flowabs_nodes.engine.keys import unit_keys
from flowabs_nodes.engine.node_events import NodeEvents
from flowabs_nodes.engine.plan import Unit, make_plan
from flowabs_nodes.engine.report import FrameReport, Note, Status
from flowabs_nodes.engine.result_store import ResultStore
from flowabs_nodes.engine.sources import Sources, source_contents
from flowabs_nodes.engine.stopwatch import Stopwatch
from flowabs_nodes.engine.unit_params import UnitParams
from flowabs_nodes.errors import FlowabsError, WriteError
from flowabs_nodes.io.frame_lock import Claim, claim
from flowabs_nodes.io.hashing import content_hash
from flowabs_nodes.io.sequences import Sequence
from flowabs_nodes.io.settings import checked
from flowabs_nodes.io.write import is_whole, save, stored_key


def render_frame(
    job: Job, frame: int, carried: CarryOver | None = None, *, nodes: NodeEvents | None = None
) -> FrameReport:
    """Render one frame of a job. Whatever goes wrong with it is in the report; only interrupts are raised.

    ``carried`` holds results of the run's earlier frames, and gets those that its later frames will ask for; without it
    nothing is held. ``nodes`` is told which node is at work.
    """
    start = time.perf_counter()
    if carried is None:
        carried = CarryOver(job.graph, (), ResultStore(0))
    carried.begin(frame)
    files = {node: tuple(Sequence(each).path(frame) for each in patterns) for node, patterns in job.outputs.items()}
    notes: list[Note] = []
    stopwatch = Stopwatch(nodes)
    if nodes is not None:
        nodes.begin_frame(frame)
    error = None
    status: Status = "failed"
    try:
        with error_boundary(frame=frame):
            status = _render(job, frame, files, notes, stopwatch, carried, nodes)
    except FlowabsError as failure:
        error = failure
        _free_images(error)
    every = tuple(path for paths in files.values() for path in paths)
    seconds = time.perf_counter() - start
    return FrameReport(frame, status, every, seconds, error, tuple(notes), tuple(stopwatch.timings))


def _render(
    job: Job,
    frame: int,
    files: dict[str, tuple[str, ...]],
    notes: list[Note],
    stopwatch: Stopwatch,
    carried: CarryOver,
    nodes: NodeEvents | None,
) -> Status:
    """Write each write node's ``files`` that are not there yet, and empty ``files`` if the frame is left out."""
    graph, options, settings = job.graph, job.options, job.options.settings
    params = UnitParams(graph)
    found = Sources(graph, params, options)
    inputs_of = FrameWindows(graph, params, found).inputs_of
    steps = make_plan(graph, frame, sinks=files, inputs_of=inputs_of)
    sources = found.of_steps(steps)
    for unit, source in sources.items():
        if source.skip:
            notes.append(Note("its file is missing: the frame is left out", unit.node))
            files.clear()
            return "skipped"
    notes.extend(found.notes(sources))

    evaluation = Evaluation(graph, params, sources, options, notes=notes, stopwatch=stopwatch)
    with stopwatch.of("(keys)", frame):
        ocio = _ocio_identity(settings.ocio)
        contents = source_contents(sources)
        keys = unit_keys(graph, steps, params, contents=contents, given={}, scale=options.scale, ocio=ocio)
        stale = {
            node: [path for path in paths if _is_stale(path, keys[Unit(node, frame)], options.existing, notes)]
            for node, paths in files.items()
        }
    stale = {node: paths for node, paths in stale.items() if paths}
    if not stale:
        notes.append(Note("nothing to do: its files are there, whole, and made from the same", detail=True))
        carried.choose((), keys)
        return "skipped"

    held_over = carried.held(steps, keys)
    notes.extend(Note("taken from an earlier frame", each.node, frame=each.frame, detail=True) for each in held_over)
    steps = make_plan(graph, frame, sinks=stale, given=held_over, inputs_of=inputs_of)
    carried.choose(steps, keys)
    if nodes is not None:
        nodes.plan(steps)
    needed = {result for step in steps for result in step.needs}
    document = json.dumps(graph.document)
    claims: dict[str, Claim] = {}

    def write(node: str, prepared: Any) -> None:
        def warn(text: str) -> None:
            notes.append(Note(text, node, warning=True))

        for path in stale[node]:
            key, claimed = keys[Unit(node, frame)], claims[path]
            save(prepared["picture"], path, key=key, graph=document, settings=settings, claimed=claimed, warn=warn)

    evaluation.on_sink = write
    evaluation.on_result = carried.put
    with ExitStack() as held:  # from before the filtering: another run that comes to this frame must not do it as well
        for path in (path for paths in stale.values() for path in paths):
            claims[path] = held.enter_context(claim(checked(path, settings)))
        evaluation.run(steps, {result: image for result, image in held_over.items() if result in needed})
    return "done"


def _is_stale(path: str, key: str, existing: str, notes: list[Note]) -> bool:
    """Return True where a file has to be written.

    Raises
    ------
    WriteError
        exists or foreign-file, where a file is in the way.
    """
    if existing == "overwrite" or not os.path.lexists(path):
        return True
    if existing == "error":
        hint = "--existing resume goes on where a run stopped, overwrite replaces"
        raise WriteError("exists already", code="exists", hint=hint, file=path)
    found = stored_key(path)
    if found is None:
        hint = "--existing overwrite replaces it"
        raise WriteError("exists already and was not written by flowabs", code="foreign-file", hint=hint, file=path)
    if found != key:
        notes.append(Note(f"made again, {path} is of another graph, plate or version"))
        return True
    if not is_whole(path):
        notes.append(Note(f"made again, {path} is damaged"))
        return True
    return False


def _ocio_identity(config: str | None) -> str:
    """Return the name of an OpenColorIO config, or for a file the hash of its content; "" for the built-in one."""
    if not config or config.startswith("ocio://"):
        return config or ""
    return content_hash(config)


def _free_images(error: BaseException) -> None:
    """Clear the stack frames of an error's tracebacks, so that a report of failure keeps no image in memory."""
    cause: BaseException | None = error
    while cause is not None:
        traceback.clear_frames(cause.__traceback__)
        cause = cause.__cause__ or cause.__context__
