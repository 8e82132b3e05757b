"""Renders many frames, in this process, in several or on Dask: by what the run asks for, or by what pays."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from flowabs_nodes import stopping
from flowabs_nodes.engine import child_python
from flowabs_nodes.engine.carry_over import CarryOver
from flowabs_nodes.engine.job import Job
from flowabs_nodes.engine.memory import SHARE, available_memory, give_back_freed_memory, peak_since_reset, reset_peak
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.engine.report import FrameReport, Note
from flowabs_nodes.engine.result_store import ResultStore
from flowabs_nodes.engine.retries import render_with_retries
from flowabs_nodes.engine.run_events import RunEvents
from flowabs_nodes.engine.unit_params import reads_other_frames
from flowabs_nodes.engine.worker_pool import Limits, WorkerPool
from flowabs_nodes.errors import WriteError
from flowabs_nodes.io.claim_watch import ClaimWatch
from flowabs_nodes.io.oiio_threads import limited_oiio
from flowabs_nodes.simd import bands

if TYPE_CHECKING:  # only where a run asks for it
    from flowabs_nodes.engine.dask_cluster import DaskCluster
    from flowabs_nodes.engine.dask_pool import DaskPool

#: Seconds of work ahead from which other processes pay, each of which takes most of a second to begin.
WORTH = 4.0

#: How many neighbouring frames one process gets where nodes look at neighbours: those at its edges are computed twice.
NEIGHBOURS = 24


def render_frames(
    job: Job,
    numbers: Sequence[int],
    options: RunOptions,
    store: ResultStore,
    tell: RunEvents,
    watch: ClaimWatch,
    cluster: DaskCluster | None = None,
) -> Iterator[FrameReport]:
    """Yield the report of each frame as it ends; once the disk is full, all further frames have failed.

    With a ``cluster`` all frames are rendered there.

    Without ``options.jobs`` frames are rendered here until two have been made, and the others in parallel if what is
    left is worth it: the first one's time is that of loading and compiling too. The pixels are the same in any case.
    """
    if cluster is not None:
        from flowabs_nodes.engine.dask_pool import DaskPool

        at_once = options.jobs or sum(place.threads for place in cluster.usable.values())
        yield from _in_parallel(DaskPool(cluster, options, tell, chunk=_chunk(job, numbers, at_once)), numbers)
        return
    limits = _limits(options, len(numbers))
    rest = deque(numbers)
    peak = made = 0
    travels = can_travel(job)
    if not travels and _needs_processes(options):
        text = "frames are rendered in this process, one at a time and without a time limit: no other process can have"
        tell.note(Note(f"{text} its nodes", warning=True))
    if not travels or not _needs_processes(options):
        carried = CarryOver(job.graph, numbers, store)
        with _limited(options.threads):
            while rest:
                stopping.check()
                reset_peak()
                report = render_with_retries(job, rest.popleft(), carried, watch=watch, nodes=tell.nodes)
                peak = peak_since_reset()
                yield report
                if _disk_is_full(report):
                    yield from _not_made(rest)
                    return
                made += report.status == "done"
                if travels and made > 1 and report.status == "done" and _pays(report.seconds, rest, limits):
                    break
        del carried
        give_back_freed_memory()
    if rest:
        pool = WorkerPool(job, limits, peak=peak, chunk=_chunk(job, rest, limits.jobs), tell=tell)
        yield from _in_parallel(pool, rest)


@contextmanager
def _limited(threads: int | None) -> Iterator[None]:
    """Have kernels, and the libraries that read and write pictures, use so many threads inside; None: all."""
    if threads is None:
        yield
        return
    with bands.limited(threads), limited_oiio(threads):
        yield


def _in_parallel(pool: WorkerPool | DaskPool, numbers: Sequence[int]) -> Iterator[FrameReport]:
    """Yield the reports of frames that processes render, and of those that are not made since the disk is full."""
    for report in pool.render(numbers):
        yield report
        if _disk_is_full(report):
            yield from _not_made(pool.drop_waiting())


def _limits(options: RunOptions, frames: int) -> Limits:
    """Return how much the run may take."""
    threads = options.threads or bands.thread_count()
    memory = options.memory_bytes or int(SHARE * available_memory())
    jobs = min(options.jobs or threads, max(1, frames))
    return Limits(jobs=jobs, threads=threads, memory=memory, timeout=options.timeout, retries=options.retries)


def _needs_processes(options: RunOptions) -> bool:
    """Return whether even one frame goes to a process of its own: only there can it be ended when it is late."""
    return (options.jobs or 1) > 1 or options.timeout is not None or options.scheduler is not None


def _pays(seconds: float, rest: Sequence[int], limits: Limits) -> bool:
    """Return whether other processes will save time, if each frame takes so many seconds in this one."""
    return limits.jobs > 1 and len(rest) > 1 and seconds * len(rest) > WORTH


def can_travel(job: Job) -> bool:
    """Return whether another process can be given the job: not nodes that a script has made up."""
    declared = (job.catalogue or {}).values()
    return child_python.can_start() and not any(
        node.run.__module__ == "__main__" or "<" in node.run.__qualname__ for node in declared
    )


def _chunk(job: Job, numbers: Sequence[int], jobs: int) -> int:
    """Return how many frames a process gets at a time, of ``jobs`` at once."""
    return min(NEIGHBOURS, math.ceil(len(numbers) / jobs)) if reads_other_frames(job.graph) else 1


def _disk_is_full(report: FrameReport) -> bool:
    return report.error is not None and report.error.code == "disk-full"


def _not_made(numbers: Sequence[int]) -> Iterator[FrameReport]:
    """Yield a report of failure for each frame that there is no space for."""
    for number in numbers:
        error = WriteError("not made: the disk is full", code="disk-full", frame=number)
        yield FrameReport(number, "failed", error=error)
