"""A process that renders frames of a job for a pool, and what it is doing."""

from __future__ import annotations

import queue
import signal
import subprocess
import threading
from contextlib import suppress
from typing import Any, BinaryIO, cast

from flowabs_nodes.engine import child_python
from flowabs_nodes.engine.job import Job
from flowabs_nodes.engine.messages import receive, send

#: Where processes put their replies: each with its process, None when that has ended.
Inbox = queue.SimpleQueue[tuple["WorkerProcess", Any]]


class WorkerProcess:
    """One process, and what it is doing."""

    def __init__(self, job: Job, inbox: Inbox, folder: str | None) -> None:
        pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
        self.process = child_python.start("flowabs_nodes.engine.worker", cwd=folder, **pipes)
        self.left: list[int] = []  # the frames that it has been asked for, the one at work first
        self.frame: int | None = None  # the one at work
        self.since = 0.0  # when that one began
        self.late = False
        threading.Thread(target=self._listen, args=(inbox,), name="flowabs-worker", daemon=True).start()
        self.ask(job)

    def ask(self, message: Any) -> None:
        """Send a message; if the process has ended its listener tells that."""
        with suppress(OSError):
            send(cast(BinaryIO, self.process.stdin), message)

    def _listen(self, inbox: Inbox) -> None:
        """Hand on each reply, and None at the end."""
        try:
            with suppress(EOFError, OSError):
                while True:
                    inbox.put((self, receive(cast(BinaryIO, self.process.stdout))))
        finally:  # whatever was not to be understood: the frame is rendered again, or has failed
            self.process.kill()
            inbox.put((self, None))

    def close(self) -> None:
        """Ask the process to end."""
        with suppress(OSError):
            cast(BinaryIO, self.process.stdin).close()

    def what_happened(self, code: int, timeout: float | None) -> str:
        """Return why the process has ended, for people: by its exit code, or because its frame took too long."""
        if self.late:
            return f"took longer than {timeout:g} s"
        if code < 0:
            with suppress(ValueError):
                return f"its process ended by {signal.Signals(-code).name}"
        return f"its process ended with exit code {code}"
