"""Have a fork wait until no other thread is in the middle of what the child could never end.

A fork copies one thread alone. What another one holds in that moment (the compiler's lock, a module half imported) is
held in the child for ever, and the child hangs where it comes to it. So such locks are taken before a fork, and let go
of after it on both sides: nobody is in the middle of anything then.

Nothing here imports more than Python's library.
"""

from __future__ import annotations

import concurrent.futures.thread
import logging
import os
import threading
import time
from typing import Any

#: Seconds that a fork waits. What lasts longer may never end, and the fork goes on without the locks that are not free.
PATIENCE = 60.0
_LOOK = 0.1  # seconds that it waits for one lock before it tries for all of them again

#: Held while a part of this package is imported that somebody asks for the first time.
IMPORTING = threading.RLock()

_guarded: list[Any] = [IMPORTING]
_taken: list[Any] = []


def take_before(*locks: Any) -> None:
    """Have each fork of this process take these locks; they are of the kinds of :mod:`threading`."""
    _guarded.extend(lock for lock in locks if lock not in _guarded)


def _before() -> None:
    """Take all locks at once: while one is not free none is kept, so that their order does not matter."""
    end = time.monotonic() + PATIENCE
    while True:
        busy = None
        for lock in _guarded:
            if lock.acquire(blocking=False):
                _taken.append(lock)
            else:
                busy = lock
        if busy is None or time.monotonic() > end:
            return
        _after()
        if busy.acquire(timeout=_LOOK):
            busy.release()


def _after() -> None:
    """Let go of the locks that were taken."""
    while _taken:
        _taken.pop().release()


# These modules of Python's take locks before a fork as well, and what registers last is asked first. While they hold
# theirs, no thread can end an import, nor a kernel begin its threads: ours must have been waited for by then.
_REGISTERED_BEFORE = (logging, concurrent.futures.thread)

if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_before, after_in_parent=_after, after_in_child=_after)
