"""Renders a sequence: runs a graph over frames, from files to files, and reports each frame."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterable, Iterator
from typing import Any

from flowabs_nodes.engine.carry_over import CarryOver
from flowabs_nodes.engine.gaps import holes
from flowabs_nodes.engine.job import Job
from flowabs_nodes.engine.job_builder import build_job
from flowabs_nodes.engine.node_events import NodeEvents
from flowabs_nodes.engine.options import RunOptions, takes_run_options
from flowabs_nodes.engine.profile import total_times
from flowabs_nodes.engine.render_frame import render_frame
from flowabs_nodes.engine.report import FrameReport, Listener, Note, Report
from flowabs_nodes.engine.result_store import ResultStore
from flowabs_nodes.engine.run_events import RunEvents
from flowabs_nodes.engine.runnable import GraphSource, load_graph
from flowabs_nodes.engine.signals import Stopped
from flowabs_nodes.engine.sources import passed_over, same_picture
from flowabs_nodes.errors import WriteError
from flowabs_nodes.io.frame_lock import sweep
from flowabs_nodes.io.settings import Settings


@takes_run_options
def run(
    graph: GraphSource,
    *,
    settings: Settings | None = None,
    profile: bool = False,
    on_event: Listener | None = None,
    **options: Any,
) -> Report:
    """Run a graph over frames, as ``flowabs run`` does.

    Parameters
    ----------
    graph
        A path, the name of a graph that comes with the package, its content as a dict, or one that is loaded.
    settings
        The options ``root``, ``max_pixels`` and ``ocio`` in one object; an option that is given itself goes before.
    profile
        Fill in ``Report.profile``: seconds by node.
    on_event
        Called with a dict for each event (:mod:`flowabs_nodes.engine.report`).
    **options
        What to read and write, which frames, and by which rules: ``input``, ``output``, ``frames``, ``set``, and all
        others of :class:`~flowabs_nodes.engine.options.RunOptions`.

    Returns
    -------
    Report
        What became of every frame, and the exit code. A frame that fails does not stop the others, except on a full
        disk. An interrupt ends the run with exit code 130 (143 for SIGTERM inside
        :func:`~flowabs_nodes.engine.signals.stop_on_signals`), without temporary files left behind.

    Raises
    ------
    GraphError, CommandError, ArgumentError, ColorError
        The graph, an option or the OCIO config is wrong; nothing has been written.
    """
    asked = RunOptions(**(vars(settings or Settings()) | options))
    return render_sequence(graph, asked, profile=profile, on_event=on_event)


def render_sequence(
    graph: GraphSource,
    options: RunOptions,
    *,
    profile: bool = False,
    on_event: Listener | None = None,
    store: ResultStore | None = None,
) -> Report:
    """Render the frames that ``options`` ask for, one after the other.

    ``store`` holds the results that later frames will ask for again, in graphs some of whose nodes read other frames
    than their own; without one they are held in 4 GiB. Its bound is on what is held from frame to frame, beside the
    pictures that one frame needs at a time. All else is as for :func:`run`.
    """
    start = time.perf_counter()
    loaded = load_graph(graph)
    if options.set:
        loaded = loaded.with_set(options.set)
    job, numbers = build_job(loaded, options)
    types = {name: node.declaration.type for name, node in job.graph.nodes.items()}
    tell = RunEvents(on_event, types, profile=profile)
    tell.start(loaded.name, len(numbers))
    about: tuple[Note, ...] = (
        *(Note(text) for text in loaded.notes),
        *(Note(str(each), warning=True) for each in loaded.warnings),
    )
    about += passed_over(job.graph) + same_picture(job.graph, len(numbers))
    about += holes(numbers) if options.frames is None else ()
    for note in about:
        tell.note(note)
    reports: list[FrameReport] = []
    carried = CarryOver(job.graph, numbers, ResultStore() if store is None else store)
    stopped = 0
    try:
        _remove_temporary_files(job)
        for report in _render_frames(job, numbers, carried, tell.nodes):
            reports.append(report)
            tell.frame(report)
    except KeyboardInterrupt as interrupt:
        stopped = interrupt.exit_code if isinstance(interrupt, Stopped) else 128 + signal.SIGINT
    finally:
        _remove_temporary_files(job)
    failed = any(report.status == "failed" for report in reports)
    ended = {report.frame for report in reports}
    result = Report(
        frames=tuple(reports),
        exit_code=stopped or int(failed),
        seconds=time.perf_counter() - start,
        notes=about,
        profile=total_times((timing for each in reports for timing in each.timings), types) if profile else None,
        not_made=tuple(number for number in numbers if number not in ended),
    )
    tell.end(result)
    return result


def _render_frames(
    job: Job, numbers: Iterable[int], carried: CarryOver, nodes: NodeEvents | None
) -> Iterator[FrameReport]:
    """Yield the report of each frame as it is rendered; once the disk is full, report all further frames as failed."""
    full = False
    for number in numbers:
        if full:
            error = WriteError("not made: the disk is full", code="disk-full", frame=number)
            yield FrameReport(number, "failed", error=error)
            continue
        report = render_frame(job, number, carried, nodes=nodes)
        full = report.error is not None and report.error.code == "disk-full"
        yield report


def _remove_temporary_files(job: Job) -> None:
    """Remove the temporary files that runs which have ended left beside the outputs of this one."""
    for patterns in job.outputs.values():
        for pattern in patterns:
            folder, name = os.path.split(pattern)
            sweep(folder or ".", name)
