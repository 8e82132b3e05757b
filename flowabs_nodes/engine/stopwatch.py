"""Takes the time of each piece of work on a frame: nodes, and what is done for no single one of them."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple, Protocol


class Timing(NamedTuple):
    """One piece of work: the node that ran, or words in brackets such as "(keys)"; on which frame; its seconds.

    Work inside of other work is a piece of its own, and its seconds are not among those of the other.
    """

    work: str
    frame: int
    seconds: float


class Watcher(Protocol):
    """Is told when a piece of work begins and ends."""

    def begins(self, work: str) -> None:
        """Take note that a piece of work begins, perhaps inside of another."""

    def ends(self, work: str, seconds: float) -> None:
        """Take note that the last piece of work that began has ended, after so many seconds, work inside included."""


class Stopwatch:
    """Takes the time of the work on one frame. ``watcher`` is told of each piece; without one nobody is."""

    def __init__(self, watcher: Watcher | None = None) -> None:
        self.timings: list[Timing] = []
        self._watcher = watcher
        self._inside = 0.0  # seconds of the pieces that have ended inside of the one at work

    @contextmanager
    def of(self, work: str, frame: int) -> Iterator[None]:
        """Take the time of what happens inside, also when it fails."""
        if self._watcher is not None:
            self._watcher.begins(work)
        before, self._inside = self._inside, 0.0
        start = time.perf_counter()
        try:
            yield
        finally:
            seconds = time.perf_counter() - start
            self.timings.append(Timing(work, frame, seconds - self._inside))
            self._inside = before + seconds
            if self._watcher is not None:
                self._watcher.ends(work, seconds)
