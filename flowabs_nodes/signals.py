"""Stops a run in good order on Ctrl-C, or on a farm's SIGTERM.

The first signal sets a flag (:mod:`flowabs_nodes.stopping`), and the run ends at the next place where it may. A second
one, or a run that goes on in spite of the flag, ends the process at once: a library's call may last, or hang. Python
itself hears of a signal only between two of its own steps, so a thread listens, to which the system's handler writes.

Nothing here imports more than Python's library: it is in place before anything else is loaded.
"""

from __future__ import annotations

import os
import select
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any

from flowabs_nodes.stopping import StopFlag, Stopped, any_set, flags, may_be_broken_off, process_flag, stopped_by

#: Seconds from the first signal until the process is ended at once.
GRACE = 20.0

#: And until work is broken off of which nothing is lost, such as compiling a kernel.
PATIENCE = 2.0

_STEP = 0.5  # seconds between two looks at it

_ASK_TO_STOP = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK") if hasattr(signal, name)
)

#: What is done before the process is ended at once: temporary files removed.
before_the_end: list[Callable[[], object]] = []

_listening = False
#: The handlers that were there before ours, by signal.
_before_ours: dict[int, Any] = {}


class _SetsFlag:
    """A handler that sets a flag at the first signal; at a further one it raises KeyboardInterrupt if ``twice``."""

    def __init__(self, flag: StopFlag, *, twice: bool = False) -> None:
        self._flag = flag
        self._twice = twice

    def __call__(self, number: int, frame: FrameType | None) -> None:
        if self._twice and self._flag.number is not None:
            raise KeyboardInterrupt
        self._flag.set(number)


def asks_to_stop(interrupt: KeyboardInterrupt) -> bool:
    """Return whether somebody may ask the work of this thread to stop by an exception that came up in it.

    False where only the code that raised it can have thought of it: Ctrl-C sets a flag here, or does nothing, and
    nobody has asked so far.
    """
    if isinstance(interrupt, Stopped) or any_set(flags()):
        return True
    handler = signal.getsignal(signal.SIGINT)
    return not (isinstance(handler, _SetsFlag) or handler is signal.SIG_IGN)


@contextmanager
def stop_on_signals() -> Iterator[None]:
    """Have the signals that ask a process to stop set its flag inside; in any thread but the main one nothing changes.

    A signal that the process was started to ignore (``nohup``) stays ignored. Who is inside asks
    :func:`flowabs_nodes.stopping.check` at the end too: a signal may come when all work is done.
    """
    if _listening or threading.current_thread() is not threading.main_thread():
        yield
        return
    with process_flag() as flag, _handlers(flag), _listener(flag):
        yield


@contextmanager
def interruptible() -> Iterator[None]:
    """Have Ctrl-C ask the work inside to stop, in place of raising KeyboardInterrupt wherever it happens to be.

    A second one raises KeyboardInterrupt at once. This is for work that is called from Python: it changes nothing
    where somebody else handles the signal, nor in any thread but the main one.
    """
    main = threading.current_thread() is threading.main_thread()
    if not main or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    flag = StopFlag()
    signal.signal(signal.SIGINT, _SetsFlag(flag, twice=True))
    try:
        with stopped_by(flag):
            yield
        if not flag.told:  # a signal that came when all was done
            flag.check()
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@contextmanager
def _handlers(flag: StopFlag) -> Iterator[None]:
    """Have signals set the flag: the handlers must be Python's, so that the system's one writes to the listener."""
    for number in _ASK_TO_STOP:
        if signal.getsignal(number) is not signal.SIG_IGN:
            _before_ours[number] = signal.signal(number, _SetsFlag(flag))
    try:
        yield
    finally:
        _restore()


def _restore() -> None:
    """Put the handlers back that were there before ours."""
    while _before_ours:
        signal.signal(*_before_ours.popitem())


@contextmanager
def _listener(flag: StopFlag) -> Iterator[None]:
    """Have a thread hear each signal while it is inside, even where the main thread is in a library's call."""
    global _listening
    ours, theirs = socket.socketpair()
    ours.setblocking(False)
    theirs.setblocking(False)
    before = signal.set_wakeup_fd(theirs.fileno(), warn_on_full_buffer=False)
    listener = threading.Thread(target=_listen, args=(ours, flag), name="flowabs-signals", daemon=True)
    _listening = True
    listener.start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(before)
        _listening = False
        theirs.close()  # the listener reads the end of it
        listener.join()
        ours.close()


def _after_fork() -> None:
    """Be a process that a signal ends, in a child that a node has forked: the thread that listens is its parent's."""
    global _listening
    if _listening:
        with suppress(ValueError):  # forked by another thread than the main one, which Python tells by a message
            signal.set_wakeup_fd(-1)
            _restore()
        _listening = False


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)


def _listen(bytes_of: socket.socket, flag: StopFlag) -> None:
    """Set the flag at the first signal; end the process at the second, or some seconds after the first."""
    heard: list[int] = []
    asked = 0.0
    while True:
        if not select.select([bytes_of], [], [], _STEP if heard else None)[0]:
            waited = time.monotonic() - asked
            if waited > PATIENCE and any(may() for may in may_be_broken_off):
                end_now(heard[0], "asked to stop while a kernel was compiled: ended now")
            if waited > GRACE:
                end_now(heard[0], f"still at work {GRACE:g} s after it was asked to stop: ended now")
            continue
        received = b""
        with suppress(BlockingIOError):
            received = bytes_of.recv(64)
            if not received:
                return
        before = len(heard)
        heard += [number for number in received if number in _ASK_TO_STOP]
        if heard and not before:
            asked = time.monotonic()
            flag.set(heard[0])
        if len(heard) > 1:
            end_now(heard[0], "asked to stop twice: ended now")


def end_now(number: int, why: str) -> None:
    """End the process without waiting for anything, but for what must not be left behind."""
    for act in before_the_end:
        with suppress(Exception):
            act()
    with suppress(OSError):
        os.write(2, f"flowabs: {why}\n".encode())
    os._exit(Stopped(number).exit_code)
