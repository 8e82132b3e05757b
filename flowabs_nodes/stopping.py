"""Ends work in good order: somebody sets a flag, and the work looks at it between frames, nodes and bands of rows.

An exception out of a signal handler can come up anywhere, inside of a lock of the compiler too, and is then lost or
leaves the lock taken. A flag is only looked at where work may end.
"""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar


class Stopped(KeyboardInterrupt):
    """Work was asked to stop. Like KeyboardInterrupt it is no Exception, and so never taken for a failure."""

    def __init__(self, number: int = signal.SIGINT) -> None:
        super().__init__(signal.Signals(number).name)
        self.number = number

    @property
    def exit_code(self) -> int:
        """Return the exit code of a process that this signal stopped: 130 for SIGINT, 143 for SIGTERM."""
        return 128 + self.number


class StopFlag:
    """Whether some work is to end. Any thread, or a signal handler, may set it; once set it stays so.

    ``number`` is the signal that asks, ``told`` is True once the work has been told.
    """

    def __init__(self) -> None:
        self.number: int | None = None
        self.told = False

    def set(self, number: int = signal.SIGINT) -> None:
        """Ask the work to stop, in the name of a signal; the first one counts."""
        if self.number is None:
            self.number = number

    def check(self) -> None:
        """Raise :class:`Stopped` if it is set."""
        if self.number is not None:
            self.told = True
            raise Stopped(self.number)


#: Each says whether work is going on that does not look at flags, and of which nothing is lost where it is broken off.
may_be_broken_off: list[Callable[[], bool]] = []

#: For all work of this process: what a signal sets that was sent to the command.
_process = StopFlag()

_work: ContextVar[tuple[StopFlag, ...]] = ContextVar("flowabs_stop_flags", default=())


def flags() -> tuple[StopFlag, ...]:
    """Return the flags that the work of this thread looks at, for threads that help it."""
    return (_process, *_work.get())


def any_set(flags: tuple[StopFlag, ...]) -> bool:
    """Return True where one of these flags is set."""
    return any(flag.number is not None for flag in flags)


def check() -> None:
    """Raise :class:`Stopped` if the work of this thread is to end."""
    for flag in flags():
        flag.check()


@contextmanager
def stopped_by(flag: StopFlag) -> Iterator[None]:
    """Have the work inside look at ``flag`` too."""
    token = _work.set((*_work.get(), flag))
    try:
        yield
    finally:
        _work.reset(token)


@contextmanager
def process_flag() -> Iterator[StopFlag]:
    """Give the flag that all work of this process looks at; at the end it is a new one, not set."""
    global _process
    before = _process
    try:
        yield before
    finally:
        if before is _process:
            _process = StopFlag()
