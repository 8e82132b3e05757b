"""Renders the frames of a run on the workers of a Dask scheduler, as :class:`WorkerPool` does in processes here.

Each task is one frame, or some neighbours. Dask moves the tasks of a worker that is lost to others; the pool counts how
often that happens to a frame, since one that ends every worker must not end them all.
"""

from __future__ import annotations

import pickle
import queue
import secrets
import threading
import time
from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from flowabs_nodes import stopping
from flowabs_nodes.engine.dask_cluster import DaskCluster
from flowabs_nodes.engine.dask_presence import DaskPresence
from flowabs_nodes.engine.dask_worker import TOPIC, Begun, Ended, Left, Task, end_run, render_task
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.engine.report import FrameReport, Note
from flowabs_nodes.engine.run_events import RunEvents
from flowabs_nodes.engine.worker_pool import expected_memory, too_large
from flowabs_nodes.errors import InternalError
from flowabs_nodes.io.claim_watch import SILENCE
from flowabs_nodes.simd import bands

_LOOK = 0.1  # seconds between two looks at whether the run is to stop
_PATIENCE = 6.0  # seconds that the workers have to give up their frames when the run stops
_POLL = 1.0  # seconds until a frame is asked for again that a worker has claimed which is lost


@dataclass
class _Sent:
    """A task that Dask has, and what is known of it: the frames that have not ended, the one at work first."""

    left: list[int]
    workers: frozenset[str]
    future: Any = None
    begun: int = 0  # times
    address: str = ""
    since: float = field(default_factory=time.monotonic)


class DaskPool:
    """Renders frames of a run on a :class:`DaskCluster`; :meth:`render` yields their reports as the frames end.

    ``chunk`` is how many neighbouring frames one worker gets at a time.
    """

    def __init__(self, cluster: DaskCluster, options: RunOptions, tell: RunEvents, *, chunk: int = 1) -> None:
        self._cluster = cluster
        self._options = options
        self._tell = tell
        self._chunk = chunk
        self._run = secrets.token_hex(8)
        self._inbox: queue.SimpleQueue[tuple[str, Any]] = queue.SimpleQueue()
        self._waiting: deque[tuple[int, ...]] = deque()
        self._later: list[tuple[float, int]] = []  # frames to ask for again, and when
        self._sent: dict[str, _Sent] = {}
        self._count = 0
        self._lost: dict[int, int] = {}  # how often a frame's worker was lost
        self._claimed_since: dict[int, float] = {}
        self._peak = 0
        self._ended = 0
        self._told_alone = False
        self._presence = DaskPresence(cluster, tell.note, self._hear)

    def render(self, numbers: Iterable[int]) -> Iterator[FrameReport]:
        """Yield the report of each frame. Raises Stopped when the run is to stop; nobody works for it any more then."""
        frames = tuple(numbers)
        self._waiting.extend(frames[at : at + self._chunk] for at in range(0, len(frames), self._chunk))
        over = threading.Event()
        self._presence.watch(over)
        try:
            while self._waiting or self._sent or self._later:
                stopping.check()
                if lost := self._presence.lost():
                    yield from self._give_up(*lost)
                yield from self._take_from_the_gone()
                self._submit()
                yield from self._handle_messages()
        finally:
            over.set()
            self._end()

    def drop_waiting(self) -> tuple[int, ...]:
        """Forget the frames that no worker has been asked for, and return them."""
        frames = (*(frame for chunk in self._waiting for frame in chunk), *(frame for _, frame in self._later))
        self._waiting.clear()
        self._later.clear()
        return frames

    # ------------------------------------------------------------------ asking

    def _submit(self) -> None:
        """Ask for as many frames as may be rendered at once."""
        now = time.monotonic()
        for due in [each for each in self._later if each[0] <= now]:
            self._later.remove(due)
            self._waiting.append((due[1],))
        usable = self._cluster.usable
        if not self._waiting or not usable or not self._presence.connected:
            return
        room = self._cluster.room(expected_memory(self._peak, self._ended, self._chunk), self._options.jobs)
        if self._peak > self._cluster.memory and not self._told_alone:
            self._told_alone = True
            self._tell.note(too_large(self._peak, self._cluster.memory))
        at_once = min(room, len(self._sent) + len(self._waiting))
        while self._waiting and len(self._sent) < at_once:
            self._send(self._waiting.popleft(), at_once, list(usable))

    def _send(self, frames: tuple[int, ...], at_once: int, workers: list[str]) -> None:
        """Give Dask one task."""
        self._count += 1
        name = f"flowabs-{self._run}-{self._count}"
        threads = self._options.threads
        if threads is None and self._cluster.local:
            threads = bands.thread_count()
        task = Task(
            run=self._run,
            name=name,
            job=self._cluster.job,
            folder=self._cluster.folder,
            frames=frames,
            threads=None if threads is None else max(1, threads // at_once),
            sharing=-(-at_once // len(workers)),
            timeout=self._options.timeout,
            retries=self._options.retries,
            listens=self._tell.nodes is not None,
        )
        sent = self._sent[name] = _Sent(list(frames), frozenset(workers))
        sent.future = self._cluster.client.submit(
            render_task, task, key=name, pure=False, workers=workers, allow_other_workers=False
        )
        sent.future.add_done_callback(lambda future: self._inbox.put((name, None)))

    # ------------------------------------------------------------------ hearing

    def _hear(self, event: tuple[float, Any]) -> None:
        """Take an event of any run; Dask's own thread calls this."""
        message = event[1]
        if isinstance(message, dict) and message.get("run") == self._run:
            self._inbox.put((message["task"], pickle.loads(message["data"])))

    def _handle_messages(self) -> Iterator[FrameReport]:
        """Wait for a message, but not for long, and yield the report of a frame that has ended."""
        self._presence.tell_news()
        try:
            name, message = self._inbox.get(timeout=_LOOK)
        except queue.Empty:
            return
        sent = self._sent.get(name)
        if sent is None:  # it has been given up
            return
        match message:
            case Begun(address):
                sent.begun += 1
                before, sent.address, sent.since = sent.address, address, time.monotonic()
                if sent.begun > 1:
                    yield from self._again(name, sent, f"its worker {before} was lost")
            case Ended(report, peak) if report.frame in sent.left:
                sent.left.remove(report.frame)
                sent.since = time.monotonic()
                if report.status == "done":
                    self._peak = max(self._peak, peak, 1)
                    self._ended += 1
                if not self._postponed(report):
                    yield report
            case Note():
                self._tell.note(message)
            case dict() if message["frame"] in sent.left:
                self._tell.node(message)
            case None:
                yield from self._done(name, sent)

    def _postponed(self, report: FrameReport) -> bool:
        """Return True for a frame that a lost worker may still claim, and ask for it again, until the claim is dead."""
        frame = report.frame
        if report.error is None or report.error.code != "claimed" or frame not in self._lost:
            return False
        since = self._claimed_since.setdefault(frame, time.monotonic())
        if time.monotonic() - since > SILENCE + 10:
            return False  # somebody lives who writes it
        self._later.append((time.monotonic() + _POLL, frame))
        return True

    def _again(self, name: str, sent: _Sent, why: str) -> Iterator[FrameReport]:
        """Tell that a frame is rendered again; yield its report of failure if that has been often enough."""
        if not sent.left:
            return
        frame = sent.left[0]
        self._lost[frame] = self._lost.get(frame, 0) + 1
        if self._lost[frame] <= self._options.retries:
            self._tell.note(Note(f"{why}: rendered again", warning=True, frame=frame))
            return
        self._forget(name)
        yield _failed(frame, why, "worker-lost", time.monotonic() - sent.since)
        if sent.left[1:]:
            self._waiting.appendleft(tuple(sent.left[1:]))

    def _done(self, name: str, sent: _Sent) -> Iterator[FrameReport]:
        """Take a task that Dask is done with; the frames in it that have not ended are asked for again, or failed."""
        status = sent.future.status
        if status == "error" and sent.left:
            error = sent.future.exception()
            text = type(error).__name__
            if text == "KilledWorker":
                yield from self._again(name, sent, "each worker that rendered it was lost")
            else:
                why = f"its worker failed: {text}: {str(error).partition(chr(10))[0]}"
                yield from self._again(name, sent, why)
        elif sent.left and self._presence.connected and self._cluster.client.status == "running":
            yield from self._again(name, sent, "its worker gave it up")
        if name in self._sent:
            self._ask_again(name, sent)

    def _ask_again(self, name: str, sent: _Sent) -> None:
        """Take a task back and have its frames that have not ended wait for another."""
        self._forget(name)
        if sent.left:
            self._waiting.appendleft(tuple(sent.left))

    # ------------------------------------------------------------------ who is gone

    def _take_from_the_gone(self) -> Iterator[FrameReport]:
        """Take back the tasks none of whose workers is there any more, since Dask waits for just these."""
        usable = self._cluster.usable.keys()
        for name, sent in list(self._sent.items()):
            if usable and not sent.workers & usable:
                if sent.begun:
                    yield from self._again(name, sent, f"its worker {sent.address} was lost")
                if name in self._sent:
                    self._ask_again(name, sent)

    def _give_up(self, why: str, code: str) -> Iterator[FrameReport]:
        """Yield the report of failure of each frame that has not ended."""
        frames = [frame for sent in self._sent.values() for frame in sent.left] + list(self.drop_waiting())
        for name in list(self._sent):
            self._forget(name)
        for frame in frames:
            yield _failed(frame, why, code)

    # ------------------------------------------------------------------ the end

    def _forget(self, name: str) -> None:
        """Take a task back, as far as Dask has not done it."""
        with suppress(Exception):  # a client that is closed
            self._sent.pop(name).future.release()

    def _end(self) -> None:
        """Take all tasks back, wait until the workers have given them up, and have them end their processes."""
        client = self._cluster.client
        at_work = {name for name, sent in self._sent.items() if sent.begun}
        for name in list(self._sent):
            self._forget(name)
        end = time.monotonic() + _PATIENCE
        while at_work and client.status == "running" and time.monotonic() < end:
            with suppress(queue.Empty):
                name, message = self._inbox.get(timeout=_LOOK)
                if isinstance(message, Left):
                    at_work.discard(name)
        if client.status == "running":
            farewell = threading.Thread(target=self._farewell, name="flowabs-dask-end", daemon=True)
            farewell.start()
            farewell.join(3.0)  # a worker that does not answer ends them itself, later

    def _farewell(self) -> None:
        """Have all workers end what waits for more frames of this run."""
        with suppress(Exception):
            self._cluster.client.unsubscribe_topic(TOPIC)
            self._cluster.client.run(end_run, self._run, workers=list(self._cluster.usable), on_error="ignore")


def _failed(frame: int, why: str, code: str, seconds: float = 0.0) -> FrameReport:
    return FrameReport(frame, "failed", seconds=seconds, error=InternalError(why, code=code, frame=frame))
