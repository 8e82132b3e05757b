"""What a worker of Dask does for a run: the other side of :mod:`flowabs_nodes.engine.dask_pool`.

A task is some frames. They are rendered in a process beside the worker (:mod:`flowabs_nodes.engine.worker_pool`), as
without Dask, and not in a thread of it, which nobody could end: a frame that is late or not wanted any more is killed
with its process, and a filter that crashes takes no other frame along. What happens goes back as events of Dask, in
order.
"""

from __future__ import annotations

import os
import pickle
import signal
import socket
import sys
import threading
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from flowabs_nodes.engine.job import Job
from flowabs_nodes.engine.memory import SHARE, available_memory
from flowabs_nodes.engine.report import FrameReport, Note
from flowabs_nodes.engine.worker_pool import Limits, WorkerPool
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.stopping import StopFlag, Stopped, stopped_by

#: The topic of all our events on a scheduler, which keeps the last ones of each topic for good: so there is only one.
TOPIC = "flowabs"

#: Seconds after which a process that has nothing to do is ended, where its run did not say that it is over.
IDLE = 30.0


@dataclass(frozen=True)
class Task:
    """Frames to render one after the other, and all that a worker needs to know for that.

    Attributes
    ----------
    run, name
        Which run asks, and which of its tasks it is: names that no other run and task has.
    job
        The pickled :class:`Job`.
    folder
        Where names of files begin that are not absolute.
    frames
        Their numbers.
    threads
        Kernel threads; None: those of the worker, shared out among ``sharing`` frames.
    sharing
        How many frames a worker renders at once.
    timeout, retries
        As in :class:`~flowabs_nodes.engine.worker_pool.Limits`.
    listens
        Somebody asks which node is at work.
    """

    run: str
    name: str
    job: bytes
    folder: str
    frames: tuple[int, ...]
    threads: int | None
    sharing: int
    timeout: float | None
    retries: int
    listens: bool


@dataclass(frozen=True)
class Begun:
    """A worker begins a task: for the second time where the worker before it was lost."""

    address: str


@dataclass(frozen=True)
class Ended:
    """What became of a frame, and the most memory, in bytes, that its process had meanwhile."""

    report: FrameReport
    peak: int


@dataclass(frozen=True)
class Left:
    """A worker has ended a task, or given it up; it does nothing more for it."""


@dataclass
class _Events:
    """Sends what happens in a pool to the run that has asked for a task."""

    task: Task
    worker: Any
    nodes: object | None = field(init=False)

    def __post_init__(self) -> None:
        self.nodes = True if self.task.listens else None

    def send(self, message: Any) -> None:
        """Send a message, which arrives after those before it."""
        data = pickle.dumps(message, pickle.HIGHEST_PROTOCOL)
        with suppress(OSError):  # the scheduler is gone: this worker will soon be
            self.worker.log_event(TOPIC, {"run": self.task.run, "task": self.task.name, "data": data})

    def note(self, note: Note) -> None:
        """Tell a note."""
        self.send(note)

    def node(self, event: dict[str, Any]) -> None:
        """Tell that a node begins or ends its work."""
        self.send(event)


class _NotWanted(StopFlag):
    """Is set once Dask has taken a task back: its run has stopped or died, or this worker is to end."""

    def __init__(self, worker: Any, key: str) -> None:
        super().__init__()
        self._worker, self._key = worker, key

    def check(self) -> None:
        """Raise Stopped if the task is not wanted any more."""
        task = self._worker.state.tasks.get(self._key)
        at_work = self._worker.status.name in ("running", "paused", "closing_gracefully")
        if not at_work or task is None or task.state not in ("executing", "long-running"):
            self.set(signal.SIGTERM)
        super().check()


#: Pools of one process each that wait for more frames, by run.
_ready: dict[str, list[WorkerPool]] = {}
_lock = threading.Lock()


def render_task(task: Task) -> None:
    """Render the frames of a task, and tell what becomes of each; a worker of Dask calls this."""
    from distributed import get_worker

    worker = get_worker()
    events = _Events(task, worker)
    events.send(Begun(worker.address))
    pool = None
    try:
        with stopped_by(_NotWanted(worker, worker.get_current_task())):
            pool = _take(task, events)
            threads = task.threads or max(1, worker.state.nthreads // max(1, task.sharing))
            pool.limits = Limits(1, threads, sys.maxsize, task.timeout, task.retries)
            for report in pool.serve(task.frames):
                events.send(Ended(report, pool.peak))
    except Stopped:
        if pool is not None:
            pool.end()
    except BaseException:
        if pool is not None:
            pool.end()
        raise
    else:
        _keep(task.run, pool)
    finally:
        events.send(Left())


def end_run(run: str) -> None:
    """End the processes that wait for more frames of a run."""
    with _lock:
        pools = _ready.pop(run, [])
    for pool in pools:
        pool.end()


def _take(task: Task, events: _Events) -> WorkerPool:
    """Return a pool that waits for frames of the task's run, or a new one."""
    with _lock:
        waiting = _ready.get(task.run, [])
        pool = waiting.pop() if waiting else None
    if pool is None:
        limits = Limits(1, 1, sys.maxsize)
        return WorkerPool(pickle.loads(task.job), limits, events, chunk=sys.maxsize, folder=task.folder)
    pool.tell = events
    return pool


def _keep(run: str, pool: WorkerPool) -> None:
    """Have a pool wait for more frames, for a while."""
    with _lock:
        _ready.setdefault(run, []).append(pool)
    timer = threading.Timer(IDLE, _end_if_idle, (run, pool))
    timer.daemon = True
    timer.start()


def _end_if_idle(run: str, pool: WorkerPool) -> None:
    """End a pool that has waited since it was last kept, or a little longer."""
    with _lock:
        waiting = _ready.get(run, [])
        if pool not in waiting:
            return
        waiting.remove(pool)
        if not waiting:
            del _ready[run]
    pool.end()


@dataclass(frozen=True)
class Place:
    """What a worker says of itself: its host, its task threads, how many bytes frames may take there.

    ``refused`` says why it can do nothing for the run, where it cannot.
    """

    host: str
    threads: int
    memory: int
    refused: str = ""


def look_around(job: bytes, folder: str, marks: Mapping[str, int], dask_worker: Any = None) -> Place:
    """Say what this worker is and whether it can render frames of a job; Dask gives ``dask_worker``.

    ``marks`` are files that the run sees, with their sizes.
    """
    limit = getattr(dask_worker.memory_manager, "memory_limit", None) or int(SHARE * available_memory())
    return Place(socket.gethostname(), dask_worker.state.nthreads, limit, _why_not(job, folder, marks))


def _why_not(job: bytes, folder: str, marks: Mapping[str, int]) -> str:
    """Return why frames of a job cannot be rendered here; "" where they can."""
    if not os.path.isdir(folder):
        return f"does not see the folder of this run, {folder}: the storage must be shared, under the same name"
    for path, size in marks.items():
        where = os.path.join(folder, path)
        try:
            found = os.stat(where).st_size
        except OSError:
            found = -1
        if found != size:
            folder_of = os.path.dirname(os.path.abspath(where))
            return f"does not see the files of this run in {folder_of}: the storage must be shared, under the same name"
    try:
        loaded: Job = pickle.loads(job)
        _ = loaded.graph
    except (FlowabsError, ImportError, AttributeError) as error:
        return f"cannot load the graph: {str(error).partition(chr(10))[0]}"
    return ""
