"""Touch files every ten seconds for as long as this process lives, so that others see from afar that it does."""

from __future__ import annotations

import os
import threading
from contextlib import suppress
from typing import Protocol

#: Seconds between two touches.
INTERVAL = 10.0


class Beating(Protocol):
    """What a heartbeat keeps alive."""

    def touch(self) -> None:
        """Change the file's time. Raises OSError."""

    def abandon(self) -> None:
        """Let go of it without a trace: this process is a copy, made by a fork, of the one that holds it."""


class Heartbeat:
    """One thread that touches everything that was added; it ends when nothing is left, and begins anew after that.

    Threads do not survive a fork. In the copy of the process everything is abandoned: it belongs to the first one.
    """

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._beating: list[Beating] = []
        self._thread: threading.Thread | None = None
        if hasattr(os, "register_at_fork"):
            os.register_at_fork(after_in_child=self._after_fork)

    def add(self, file: Beating) -> None:
        """Touch a file from now on, every :data:`INTERVAL` seconds."""
        with self._changed:
            self._beating.append(file)
            if self._thread is None:
                thread = threading.Thread(target=self._run, name="flowabs-heartbeat", daemon=True)
                with suppress(RuntimeError):  # no more threads: the next claim tries again
                    thread.start()
                    self._thread = thread

    def remove(self, file: Beating) -> None:
        """Touch a file no more; when this returns it is not being touched either."""
        with self._changed:
            if file in self._beating:
                self._beating.remove(file)

    @property
    def beats(self) -> bool:
        """True while the thread runs: up to :data:`INTERVAL` seconds longer than there is something to touch."""
        return self._thread is not None

    def _run(self) -> None:
        """Touch all files time and again, until there are none."""
        with self._changed:
            while True:
                self._changed.wait(INTERVAL)
                if not self._beating:
                    self._thread = None
                    return
                for file in self._beating:
                    with suppress(OSError):  # gone, or the disk is full: its lock may still tell
                        file.touch()

    def _after_fork(self) -> None:
        """Begin as a process that holds nothing, whatever the lock of the other one's thread was at."""
        beating, self._beating = self._beating, []
        self._changed = threading.Condition()
        self._thread = None
        for file in beating:
            file.abandon()


#: The heartbeat of this process.
HEARTBEAT = Heartbeat()
