"""Runs a graph over frames: reads files, writes files, reports each frame."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from flowabs_nodes.engine.job import Job
from flowabs_nodes.engine.job_builder import PathLike, prepare
from flowabs_nodes.engine.profile import total_times
from flowabs_nodes.engine.render_frame import run_frame
from flowabs_nodes.engine.report import (
    FrameReport,
    Listener,
    Note,
    Report,
    end_event,
    frame_event,
    note_event,
    start_event,
)
from flowabs_nodes.engine.runnable import load_graph
from flowabs_nodes.engine.signals import Stopped
from flowabs_nodes.errors import WriteError
from flowabs_nodes.graph.model import Graph
from flowabs_nodes.io.frame_lock import sweep
from flowabs_nodes.io.settings import Settings


def run(
    graph: str | Path | Mapping[str, Any] | Graph,
    *,
    input: PathLike | None = None,
    output: PathLike | Iterable[PathLike] | None = None,
    frames: str | int | Iterable[int] | None = None,
    set: Mapping[str, Any] | None = None,
    scale: float = 1.0,
    existing: str = "resume",
    missing: str | None = None,
    profile: bool = False,
    settings: Settings | None = None,
    on_event: Listener | None = None,
) -> Report:
    """Run a graph over frames, as ``flowabs run`` does.

    Parameters
    ----------
    graph
        A path, the name of a graph that comes with the package, its content as a dict, or one that is loaded.
    input
        File or pattern (``shot.####.exr``) of the graph's only ``read``.
    output
        File or pattern of the graph's only ``write``; of several, each further one gets the same image in its format.
    frames
        A range such as ``"1001-1100x2,1200"``, or numbers. Without it every frame that is on disk; a single picture is
        frame 1.
    set
        Values of knobs and parameters: ``{"line_width": 1.5, "lines.softness": 2}``.
    scale
        Above 0 up to 1: filters and writes a smaller picture, with lengths to match.
    existing
        About files that are there: "resume" keeps what is whole and has the right key, "overwrite" makes all again,
        "error" fails those frames.
    missing
        About missing input frames, before the nodes' own policy: error, hold, nearest, black, skip.
    profile
        Fill in ``Report.profile``: seconds by node.
    on_event
        Called with a dict for each event (:mod:`flowabs_nodes.engine.report`).

    Returns
    -------
    Report
        Every frame's fate, and the exit code. A frame that fails does not stop the others, except on a full disk. An
        interrupt ends the run with exit code 130 (143 for SIGTERM inside
        :func:`~flowabs_nodes.engine.signals.stop_on_signals`), without temporary files left behind.

    Raises
    ------
    GraphError, CommandError, ColorError
        The graph or the command is wrong, or its OCIO config; nothing has been written.
    """
    start = time.perf_counter()
    loaded = load_graph(graph)
    if set:
        loaded = loaded.with_set(set)
    job, numbers = prepare(
        loaded,
        input=input,
        output=output,
        frames=frames,
        scale=scale,
        existing=existing,
        missing=missing,
        settings=settings,
    )
    tell: Listener = on_event or (lambda event: None)
    tell(start_event(loaded.name, len(numbers)))
    about = (*(Note(text) for text in loaded.notes), *(Note(str(each), warning=True) for each in loaded.warnings))
    for note in about:
        tell(note_event(note))
    reports: list[FrameReport] = []
    said: dict[tuple[str, str], None] = {}
    stopped = 0
    try:
        _sweep(job)
        for report in _each(job, numbers):
            reports.append(report)
            for note in _unsaid(report.notes, said):
                tell(note_event(note, report.frame))
            tell(frame_event(report))
    except KeyboardInterrupt as interrupt:
        stopped = interrupt.exit_code if isinstance(interrupt, Stopped) else 128 + signal.SIGINT
    finally:
        _sweep(job)
    failed = any(report.status == "failed" for report in reports)
    types = {name: node.declaration.type for name, node in job.graph.nodes.items()}
    result = Report(
        frames=tuple(reports),
        exit_code=stopped or int(failed),
        seconds=time.perf_counter() - start,
        notes=about,
        profile=total_times((each.timings for each in reports), types) if profile else None,
    )
    tell(end_event(result))
    return result


def _each(job: Job, numbers: Iterable[int]) -> Iterator[FrameReport]:
    """Each frame's report as it is made. On a full disk nothing more can be: the rest is reported as failed."""
    full = False
    for number in numbers:
        if full:
            error = WriteError("not made: the disk is full", code="disk-full", frame=number)
            yield FrameReport(number, "failed", error=error)
            continue
        report = run_frame(job, number)
        full = report.error is not None and report.error.code == "disk-full"
        yield report


def _unsaid(notes: Iterable[Note], said: dict[tuple[str, str], None]) -> Iterator[Note]:
    """The notes without those that were to be said once, and have been."""
    for note in notes:
        if not note.once or (note.node, note.once) not in said:
            said[note.node, note.once] = None
            yield note


def _sweep(job: Job) -> None:
    """Remove the temporary files of runs that are no more, beside the files of this one."""
    for patterns in job.outputs.values():
        for pattern in patterns:
            folder, name = os.path.split(pattern)
            sweep(folder or ".", name)
