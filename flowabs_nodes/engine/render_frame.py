"""Renders one frame of a run: finds its files, sees which results are there already, computes and writes the others."""

from __future__ import annotations

import json
import time
import traceback
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

from flowabs_nodes.color.config import opened
from flowabs_nodes.engine.carry_over import CarryOver
from flowabs_nodes.engine.error_boundary import error_boundary
from flowabs_nodes.engine.evaluate import Evaluation
from flowabs_nodes.engine.existing import Origin, State, is_stale, made_since, state_of
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
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.io import formats
from flowabs_nodes.io.claim import claim
from flowabs_nodes.io.claim_watch import ClaimWatch
from flowabs_nodes.io.sequences import Sequence
from flowabs_nodes.io.settings import checked
from flowabs_nodes.io.write import Picture, save


@dataclass(frozen=True)
class _Around:
    """What the rendering of a frame is told of the rest of its run."""

    carried: CarryOver
    watch: ClaimWatch | None
    left: Mapping[str, State]
    nodes: NodeEvents | None


def render_frame(
    job: Job,
    frame: int,
    carried: CarryOver | None = None,
    *,
    watch: ClaimWatch | None = None,
    left: Mapping[str, State] | None = None,
    nodes: NodeEvents | None = None,
) -> FrameReport:
    """Render one frame of a job. Whatever goes wrong with it is in the report; only interrupts are raised.

    ``carried`` holds results of the run's earlier frames, and gets those that its later frames will ask for; without it
    nothing is held. ``watch`` knows what the run has seen of other runs' claims. A frame that another run is writing
    fails with the code "claimed". ``left`` says how its files were when the frame was left to another run: what has
    been written since, with the key that this run would give it, counts as made. ``nodes`` is told which node is at
    work.
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
            around = _Around(carried, watch, left or {}, nodes)
            status = _render(job, frame, files, notes, stopwatch, around)
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
    around: _Around,
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
        ocio = opened(settings.ocio).content
        contents = source_contents(sources)
        keys = unit_keys(graph, steps, params, contents=contents, given={}, scale=options.scale, ocio=ocio)
        of_file = {path: keys[Unit(node, frame)] for node, paths in files.items() for path in paths}
        before = {path: state_of(path) for path in of_file}
        origin = Origin(graph.name, options.scale)
        stale = [
            path
            for path, key in of_file.items()
            if not made_since(path, key, around.left) and is_stale(path, key, origin, options.existing, notes)
        ]
    with ExitStack() as held:  # from before the filtering: another run that comes to this frame must not do it as well
        claims = {
            path: held.enter_context(claim(checked(path, settings), around.watch, settings.root)) for path in stale
        }
        stale = [path for path in stale if not made_since(path, of_file[path], before)]  # while this run was looking
        if not stale:
            notes.append(Note("nothing to do: its files are there, whole, and made from the same", detail=True))
            around.carried.choose((), keys)
            return "skipped"
        wanted = {node: [path for path in paths if path in stale] for node, paths in files.items()}
        held_over = around.carried.held(steps, keys)
        notes.extend(Note("taken from an earlier frame", it.node, frame=it.frame, detail=True) for it in held_over)
        steps = make_plan(
            graph, frame, sinks=[node for node in wanted if wanted[node]], given=held_over, inputs_of=inputs_of
        )
        around.carried.choose(steps, keys)
        if around.nodes is not None:
            around.nodes.plan(steps)
        document = json.dumps(graph.document)

        def write(node: str, prepared: Any) -> None:
            def warn(text: str) -> None:
                notes.append(Note(text, node, warning=True))

            picture: Picture = prepared["picture"]
            if picture.layers and all(formats.to_write(path).display_referred for path in files[node]):
                names = f"layer{'s' if len(picture.layers) > 1 else ''} {', '.join(picture.layers)}"
                notes.append(Note(f"left out: {names}, which only an EXR holds (-o FILE.exr, beside others)", node))
            for path in wanted[node]:
                save(
                    picture,
                    path,
                    key=of_file[path],
                    graph=document,
                    scale=options.scale,
                    settings=settings,
                    claimed=claims[path],
                    warn=warn,
                )

        evaluation.on_sink = write
        evaluation.on_result = around.carried.put
        needed = {result for step in steps for result in step.needs}
        evaluation.run(steps, {result: image for result, image in held_over.items() if result in needed})
    return "done"


def _free_images(error: BaseException) -> None:
    """Clear the stack frames of an error's tracebacks, so that a report of failure keeps no image in memory."""
    cause: BaseException | None = error
    while cause is not None:
        traceback.clear_frames(cause.__traceback__)
        cause = cause.__cause__ or cause.__context__
