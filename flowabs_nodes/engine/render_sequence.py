"""Renders a sequence: runs a graph over frames, from files to files, and reports each frame."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any

from flowabs_nodes import stopping
from flowabs_nodes.engine.gaps import holes
from flowabs_nodes.engine.job import Job
from flowabs_nodes.engine.job_builder import build_job
from flowabs_nodes.engine.ocio_choice import choose_config
from flowabs_nodes.engine.options import RunOptions, takes_run_options
from flowabs_nodes.engine.profile import total_times
from flowabs_nodes.engine.render_frames import can_travel, render_frames
from flowabs_nodes.engine.report import FrameReport, Listener, Note, Report
from flowabs_nodes.engine.result_store import ResultStore
from flowabs_nodes.engine.retries import render_with_retries
from flowabs_nodes.engine.run_events import RunEvents
from flowabs_nodes.engine.runnable import GraphSource, load_graph
from flowabs_nodes.engine.shared_sequence import SharedSequence
from flowabs_nodes.engine.sources import passed_over, same_picture
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.signals import interruptible
from flowabs_nodes.stopping import Stopped

if TYPE_CHECKING:  # only where a run asks for it
    from flowabs_nodes.engine.dask_cluster import DaskCluster


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
        disk. Ctrl-C ends the run with exit code 130, without temporary files left behind; a second one raises
        KeyboardInterrupt at once.

    Raises
    ------
    GraphError, CommandError, ArgumentError, ColorError
        The graph, an option or the OCIO config is wrong; nothing has been written.
    """
    asked = RunOptions(**(vars(settings or Settings()) | options))
    with interruptible():
        return render_sequence(graph, asked, profile=profile, on_event=on_event)


def render_sequence(
    graph: GraphSource,
    options: RunOptions,
    *,
    profile: bool = False,
    on_event: Listener | None = None,
    store: ResultStore | None = None,
) -> Report:
    """Render the frames that ``options`` ask for.

    ``store`` holds the results that later frames will ask for again, in graphs some of whose nodes read other frames
    than their own; without one they are held in 4 GiB. Its bound is on what is held from frame to frame, beside the
    pictures that one frame needs at a time. All else is as for :func:`run`.
    """
    start = time.perf_counter()
    loaded = load_graph(graph)
    if options.set:
        loaded = loaded.with_set(options.set)
    options, about_colors = choose_config(options)
    job, numbers = build_job(loaded, options)
    with _cluster(job, numbers, options) as cluster:
        types = {name: node.declaration.type for name, node in job.graph.nodes.items()}
        tell = RunEvents(on_event, types, profile=profile)
        tell.start(loaded.name, len(numbers))
        about: tuple[Note, ...] = (
            *(Note(text) for text in loaded.notes),
            *(Note(str(each), warning=True) for each in loaded.warnings),
        )
        about += about_colors + passed_over(job.graph) + same_picture(job.graph, len(numbers))
        about += holes(numbers) if options.frames is None else ()
        about += tuple(cluster.notes) if cluster else ()
        for note in about:
            tell.note(note)
        reports: dict[int, FrameReport] = {}
        shared = SharedSequence(job, numbers)
        stopped = 0
        try:
            shared.sweep()
            held = ResultStore() if store is None else store
            for report in _reports(job, numbers, options, held, shared, tell, cluster):
                reports[report.frame] = report
                tell.frame(report)
            stopping.check()
        except KeyboardInterrupt as interrupt:
            stopped = (interrupt if isinstance(interrupt, Stopped) else Stopped()).exit_code
        finally:
            shared.sweep()
        failed = any(report.status == "failed" for report in reports.values())
        timings = (timing for report in reports.values() for timing in report.timings)
        result = Report(
            frames=tuple(reports[number] for number in numbers if number in reports),
            exit_code=stopped or int(failed),
            seconds=time.perf_counter() - start,
            notes=about,
            profile=total_times(timings, types) if profile else None,
            not_made=tuple(number for number in numbers if number not in reports),
        )
        tell.end(result)
        return result


def _cluster(job: Job, numbers: tuple[int, ...], options: RunOptions) -> AbstractContextManager[DaskCluster | None]:
    """Return the workers of Dask that the run is to use; None where it asks for none, or they cannot have its nodes."""
    if options.scheduler is None or not can_travel(job):
        return nullcontext()
    from flowabs_nodes.engine.dask_cluster import dask_cluster

    return dask_cluster(job, numbers, options)


def _reports(
    job: Job,
    numbers: tuple[int, ...],
    options: RunOptions,
    store: ResultStore,
    shared: SharedSequence,
    tell: RunEvents,
    cluster: DaskCluster | None,
) -> Iterator[FrameReport]:
    """Yield the report of each frame as it ends; frames that other runs are writing come last."""
    for report in render_frames(job, numbers, options, store, tell, shared.watch, cluster):
        if not shared.leaves(report):
            yield report
    yield from shared.settle(
        lambda number, left: render_with_retries(job, number, watch=shared.watch, left=left, nodes=tell.nodes),
        tell.note,
    )
