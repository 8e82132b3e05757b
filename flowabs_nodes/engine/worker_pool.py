"""Renders the frames of a run in parallel processes, as many as a memory budget and the processors allow.

The first frame is rendered alone; the most memory that it took says how many may be rendered at once. A process that is
lost costs only its frames, which are rendered again. Each worker of Dask has such a pool of one process for a frame at
work (:mod:`flowabs_nodes.engine.dask_worker`).
"""

from __future__ import annotations

import queue
import signal
import subprocess
import time
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Protocol

from flowabs_nodes import signals, stopping
from flowabs_nodes.engine.job import Job
from flowabs_nodes.engine.memory import resident
from flowabs_nodes.engine.report import FrameReport, Note
from flowabs_nodes.engine.worker import AtWork, Begun, Ended, Request
from flowabs_nodes.engine.worker_process import Inbox, WorkerProcess
from flowabs_nodes.errors import InternalError

_LOOK = 0.1  # seconds between two looks at whether the run is to stop
_PATIENCE = 5.0  # seconds that a process has to give up its frame when the run stops

#: So many frames have to end until what they took is what others take that read their neighbours too.
SETTLED = 5


@dataclass(frozen=True)
class Limits:
    """How much a pool may take.

    Attributes
    ----------
    jobs
        The most processes.
    threads
        Kernel threads, shared out among the processes.
    memory
        Bytes that this process and all others may have together.
    timeout
        Seconds that one frame may take; None: any time.
    retries
        How often a frame is rendered again whose process was lost.
    """

    jobs: int
    threads: int
    memory: int
    timeout: float | None = None
    retries: int = 1


class PoolEvents(Protocol):
    """Is told what happens in a pool (:class:`~flowabs_nodes.engine.run_events.RunEvents` is)."""

    @property
    def nodes(self) -> object | None:
        """Return None where nobody asks which node is at work."""

    def note(self, note: Note) -> None:
        """Tell what happened to a process."""

    def node(self, event: dict[str, Any]) -> None:
        """Tell that a node begins or ends its work."""


class WorkerPool:
    """Renders frames of a job in other processes; :meth:`render` yields their reports as the frames end.

    ``peak`` is the most memory that a process takes for a frame, as far as it is known. ``tell`` is told what happens
    to processes, and which node is at work. ``folder`` is where names of files begin that are not absolute: where this
    process is, unless it is given.
    """

    def __init__(
        self, job: Job, limits: Limits, tell: PoolEvents, *, peak: int = 0, chunk: int = 1, folder: str | None = None
    ) -> None:
        self._job = job
        self.limits = limits
        self._jobs = limits.jobs
        self.peak = peak
        self._chunk = chunk
        self._folder = folder
        self.tell = tell
        self._inbox: Inbox = queue.SimpleQueue()
        self._workers: list[WorkerProcess] = []
        self._leaving: list[WorkerProcess] = []  # asked to end
        self._waiting: deque[tuple[int, ...]] = deque()
        self._tries: dict[int, int] = {}
        self._ended = 0
        self._told_alone = False

    def render(self, numbers: Iterable[int]) -> Iterator[FrameReport]:
        """Yield the report of each frame. Raises Stopped when the run is to stop; no process is left then."""
        signals.before_the_end.append(self._kill)
        try:
            yield from self.serve(numbers)
        finally:
            self.end()
            signals.before_the_end.remove(self._kill)

    def serve(self, numbers: Iterable[int]) -> Iterator[FrameReport]:
        """Yield reports as :meth:`render` does, and leave the processes ready for more, until :meth:`end`."""
        frames = tuple(numbers)
        self._waiting.extend(frames[at : at + self._chunk] for at in range(0, len(frames), self._chunk))
        while self._waiting or self._busy():
            stopping.check()
            self._assign()
            yield from self._handle_messages()

    def drop_waiting(self) -> tuple[int, ...]:
        """Forget the frames that no process has begun, and return them."""
        frames = tuple(frame for chunk in self._waiting for frame in chunk)
        self._waiting.clear()
        return frames

    def _busy(self) -> list[WorkerProcess]:
        return [worker for worker in self._workers if worker.left]

    def _at_once(self) -> int:
        """Return how many frames may be rendered at once."""
        if not self.peak:
            return 1
        left = self.limits.memory - resident()
        fit = left // expected_memory(self.peak, self._ended, self._chunk)
        if left < self.peak and not self._told_alone:
            self._told_alone = True
            self.tell.note(too_large(self.peak, self.limits.memory))
        return max(1, min(self._jobs, fit))

    def _assign(self) -> None:
        """Start processes, give each that is idle some frames, and end those that are too many."""
        at_once = self._at_once()
        useful = min(self._jobs if not self.peak else at_once, len(self._waiting) + len(self._busy()))
        while len(self._workers) < useful:
            self._workers.append(WorkerProcess(self._job, self._inbox, self._folder))
        idle = [worker for worker in self._workers if not worker.left]
        for worker in idle[: max(0, len(self._workers) - useful)]:
            self._workers.remove(worker)
            self._leaving.append(worker)
            worker.close()
            idle.remove(worker)
        for worker in idle:
            busy = len(self._busy())
            if busy >= at_once or not self._waiting:
                break
            frames = self._waiting.popleft()
            sharing = min(at_once, busy + 1 + len(self._waiting))
            worker.left = list(frames)
            worker.since = time.monotonic()
            threads = max(1, self.limits.threads // sharing)
            worker.ask(Request(frames, threads, listens=self.tell.nodes is not None))

    def _handle_messages(self) -> Iterator[FrameReport]:
        """Wait for a message, but not for long, and yield the report of a frame that has ended."""
        try:
            worker, message = self._inbox.get(timeout=_LOOK)
        except queue.Empty:
            self._kill_late_ones()
            return
        match message:
            case Begun(frame):
                worker.frame, worker.since = frame, time.monotonic()
            case AtWork(event):
                self.tell.node(event)
            case Ended(report, peak):
                worker.frame = None
                worker.left.remove(report.frame)
                if report.status == "done":  # to look at a frame that is there takes less
                    self.peak = max(self.peak, peak, 1)
                    self._ended += 1
                yield report
            case None if worker in self._workers:
                self._workers.remove(worker)
                yield from self._lost(worker)
        self._kill_late_ones()

    def _kill_late_ones(self) -> None:
        """End the processes whose frame takes longer than it may."""
        if self.limits.timeout is None:
            return
        for worker in self._busy():
            if worker.frame is not None and time.monotonic() - worker.since > self.limits.timeout:
                worker.late = True
                worker.process.kill()

    def _lost(self, worker: WorkerProcess) -> Iterator[FrameReport]:
        """Have the frames of a process that has ended rendered again, or yield the report of the one that failed."""
        code = worker.process.wait()
        if not worker.left:
            return
        frame, seconds = worker.left[0], time.monotonic() - worker.since
        killed = code == -signal.SIGKILL and not worker.late
        alone = not self._busy()
        if killed and not alone:  # by the system, when it has no memory left
            self._jobs = max(1, len(self._busy()))
            text = f"its process was killed, probably for want of memory: {self._jobs} at a time from now on"
            self.tell.note(Note(text, warning=True, frame=frame))
        elif self._tries.get(frame, 0) < self.limits.retries:
            self._tries[frame] = self._tries.get(frame, 0) + 1
            text = f"{worker.what_happened(code, self.limits.timeout)}: rendered again"
            self.tell.note(Note(text, warning=True, frame=frame))
        else:
            worker.left.remove(frame)
            error = InternalError(
                worker.what_happened(code, self.limits.timeout),
                code="timeout" if worker.late else "worker-lost",
                hint="--timeout says how long a frame may take" if worker.late else "",
                frame=frame,
            )
            yield FrameReport(frame, "failed", seconds=seconds, error=error)
        if worker.left:
            self._waiting.appendleft(tuple(worker.left))

    def end(self) -> None:
        """End all processes: each gives up its frame, or is killed."""
        for worker in self._workers:
            worker.close()
            if worker.frame is None:  # nothing to give up
                worker.process.kill()
        self._leaving += self._workers
        end = time.monotonic() + (_PATIENCE if self._busy() else 0.0)
        for worker in self._leaving:
            try:
                worker.process.wait(max(0.0, end - time.monotonic()))
            except subprocess.TimeoutExpired:
                worker.process.kill()
                worker.process.wait()
        self._workers.clear()
        self._leaving.clear()

    def _kill(self) -> None:
        """Kill all processes, at once."""
        for worker in [*self._workers, *self._leaving]:
            worker.process.kill()


def expected_memory(peak: int, ended: int, chunk: int) -> int:
    """Return how many bytes a frame is expected to take, if of those that have ``ended`` one took ``peak`` at most.

    A process that gets a ``chunk`` of neighbouring frames takes more with each of the first ones: at the start of a
    sequence windows are half, and there are no results yet that are held for others.
    """
    return 2 * peak if chunk > 1 and ended < SETTLED else peak


def too_large(peak: int, memory: int) -> Note:
    """Return the warning that a frame takes more bytes than there are for all frames at once."""
    need, given = f"{peak / 1e9:.2f} GB", f"{memory / 1e9:.2f} GB"
    text = f"a frame takes {need}, more than the memory of this run ({given}) leaves: one at a time"
    return Note(text, warning=True)
