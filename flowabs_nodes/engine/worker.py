"""A process that renders frames for a run: the other side of :mod:`flowabs_nodes.engine.worker_pool`.

Requests come on standard input: first the job, then some frames at a time. What becomes of them goes to what was
standard output. When the input ends (the run stops, or its process has died) the frame at work is given up; if it does
not let go (a read that hangs), the process is ended all the same.
"""

from __future__ import annotations

import os
import queue
import signal
import sys
import threading
import time
from dataclasses import dataclass
from typing import Any, BinaryIO

from flowabs_nodes import signals
from flowabs_nodes.engine.carry_over import CarryOver
from flowabs_nodes.engine.job import Job
from flowabs_nodes.engine.memory import peak_since_reset, reset_peak
from flowabs_nodes.engine.messages import receive, send
from flowabs_nodes.engine.node_events import NodeEvents
from flowabs_nodes.engine.report import FrameReport
from flowabs_nodes.engine.result_store import ResultStore
from flowabs_nodes.engine.retries import render_with_retries
from flowabs_nodes.io.claim_watch import ClaimWatch
from flowabs_nodes.io.oiio_threads import limited_oiio
from flowabs_nodes.signals import stop_on_signals
from flowabs_nodes.simd import bands
from flowabs_nodes.stopping import StopFlag, Stopped, stopped_by


@dataclass(frozen=True)
class Request:
    """Frames to render one after the other, with so many kernel threads; somebody ``listens`` to which node works."""

    frames: tuple[int, ...]
    threads: int
    listens: bool = False


@dataclass(frozen=True)
class Begun:
    """A frame is being rendered from now on."""

    frame: int


@dataclass(frozen=True)
class AtWork:
    """A node begins or ends its work: the event (:class:`~flowabs_nodes.engine.node_events.NodeEvents`)."""

    event: dict[str, Any]


@dataclass(frozen=True)
class Ended:
    """What became of a frame, and the most memory, in bytes, that the process had meanwhile."""

    report: FrameReport
    peak: int


def main() -> None:
    """Render what is asked for, until standard input ends."""
    # Ctrl-C on a terminal goes to every process; it is the run that tells its workers.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    replies = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a node prints is no message
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(after_in_child=lambda: _leave(replies))
    flag = StopFlag()
    requests: queue.SimpleQueue[Any] = queue.SimpleQueue()
    threading.Thread(target=_read_requests, args=(sys.stdin.buffer, requests, flag), daemon=True).start()
    code = 0
    try:
        with stop_on_signals(), stopped_by(flag):
            _serve(requests, replies)
    except Stopped as stopped:
        code = stopped.exit_code
    except OSError:  # nobody reads any more
        code = 1
    os._exit(code)


def _leave(replies: BinaryIO) -> None:
    """Let go of the pipe in a process that a node has forked: the run hears of the end of this one by the pipe's."""
    nothing = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, replies.fileno(), inheritable=False)
    os.close(nothing)


def _read_requests(pipe: BinaryIO, requests: queue.SimpleQueue[Any], flag: StopFlag) -> None:
    """Hand on each request; at the end of the input ask the work to stop, and end the process if it does not."""
    try:
        while True:
            requests.put(receive(pipe))
    except (EOFError, OSError):
        flag.set()
        requests.put(None)
    time.sleep(signals.GRACE)
    signals.end_now(signal.SIGTERM, f"a process whose run has ended is still at work {signals.GRACE:g} s later: ended")


def _serve(requests: queue.SimpleQueue[Any], replies: BinaryIO) -> None:
    """Answer requests until there are no more."""
    job: Job = requests.get()
    watch = ClaimWatch()
    types = {name: node.declaration.type for name, node in job.graph.nodes.items()}
    nodes = NodeEvents(lambda event: send(replies, AtWork(event)), types)
    while (request := requests.get()) is not None:
        carried = CarryOver(job.graph, request.frames, ResultStore())
        for frame in request.frames:
            send(replies, Begun(frame))
            reset_peak()
            with bands.limited(request.threads), limited_oiio(request.threads):
                report = render_with_retries(job, frame, carried, watch=watch, nodes=nodes if request.listens else None)
            send(replies, Ended(report, peak_since_reset()))
