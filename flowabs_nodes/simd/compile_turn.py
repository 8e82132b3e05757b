"""Taking turns: of several processes that need the same kernel, one compiles it and the others wait for its file.

The turn is a lock of the operating system on an empty file, which goes with the process that holds it, however that
ends; a child that it forks meanwhile has no turn. Where there are no such locks, or somebody holds one for too long,
everybody compiles: slower, and as right.
"""

from __future__ import annotations

import importlib
import os
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from flowabs_nodes import stopping

PATIENCE = 120.0  # seconds; the longest kernel takes two
_STEP = 0.01  # seconds between two looks at a lock

_system: Any = importlib.import_module("msvcrt" if sys.platform == "win32" else "fcntl")
_held: dict[Path, int] = {}  # file descriptors of this process's turns


stopping.may_be_broken_off.append(lambda: bool(_held))


def take(file: Path) -> None:
    """Wait for the turn that ``file`` stands for, but not for ever."""
    give(file)  # of a compilation that failed
    try:
        fd = os.open(file, os.O_RDWR | os.O_CREAT, 0o644)
    except OSError:  # a folder that has just been moved away
        return
    end = time.monotonic() + PATIENCE
    try:
        flags = stopping.flags()
        while not _lock(fd) and time.monotonic() < end and not stopping.any_set(flags):
            time.sleep(_STEP)
    except OSError:  # a file system without locks
        os.close(fd)
    except BaseException:
        os.close(fd)
        raise
    else:
        _held[file] = fd


def give(file: Path) -> None:
    """Let the next one have the turn, if this process has it."""
    fd = _held.pop(file, None)
    if fd is not None:
        if sys.platform != "win32":
            with suppress(OSError):
                _system.flock(fd, _system.LOCK_UN)  # to close it is not enough where a fork has a copy of it
        os.close(fd)


def _give_up() -> None:
    """Close the files of the turns that are the parent's, which stay locked, in a child that it forked."""
    while _held:
        with suppress(OSError):
            os.close(_held.popitem()[1])


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_give_up)


def _lock(fd: int) -> bool:
    """Lock a file, or return False where somebody else has; raises OSError where files cannot be locked."""
    if sys.platform == "win32":
        with suppress(PermissionError):
            _system.locking(fd, _system.LK_NBLCK, 1)
            return True
        return False
    try:
        _system.flock(fd, _system.LOCK_EX | _system.LOCK_NB)
    except BlockingIOError:
        return False
    return True
