"""Lock files, and know how far such a lock reaches: who else can see that it is held."""

from __future__ import annotations

import hashlib
import importlib
import os
import stat
import subprocess
from contextlib import suppress
from functools import cache
from typing import Any

fcntl: Any
try:
    fcntl = importlib.import_module("fcntl")
except ImportError:  # Windows
    fcntl = None

#: The reach of a lock that nobody else can see.
NOWHERE = "0" * 8


def lock(fd: int) -> bool:
    """Lock an open file, after those who only look; return False where the file system has no locks."""
    if fcntl is None:
        return False
    try:
        fcntl.flock(fd, fcntl.LOCK_EX)
    except OSError:
        return False
    return True


def unlock(fd: int) -> None:
    """Unlock an open file, for every process that a fork gave a copy of it to: closing it would unlock it for none."""
    if fcntl is not None:
        with suppress(OSError):
            fcntl.flock(fd, fcntl.LOCK_UN)


def is_locked(path: str | os.PathLike[str]) -> bool | None:
    """Return True where some other open file holds the lock, False where it is free, None where that cannot be told."""
    if fcntl is None:
        return None
    fd = open_regular(path)
    if fd is None:
        return None
    try:  # shared, so that two who look at once do not see each other; and NFS lets a file open for reading no more
        fcntl.flock(fd, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return None
    else:
        unlock(fd)
        return False
    finally:
        os.close(fd)


def open_regular(path: str | os.PathLike[str]) -> int | None:
    """Open a regular file for reading; None for all else: a pipe, a device, a link, or what cannot be opened."""
    harmless = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
    try:
        fd = os.open(path, os.O_RDONLY | harmless)
    except OSError:
        return None
    if stat.S_ISREG(os.fstat(fd).st_mode):
        return fd
    os.close(fd)
    return None


def reach(folder: str | os.PathLike[str]) -> str:
    """Return eight digits that stand for all processes that see each other's locks in a folder.

    These are the processes of one running kernel, on one mounted file system: of all containers on a machine, but of
    no other machine, even one of the same name. Locks may well reach further, over NFS, but nothing says so.
    :data:`NOWHERE` is returned where the kernel cannot be told from others.
    """
    kernel = _kernel()
    if fcntl is None or not kernel:
        return NOWHERE
    try:
        device = os.stat(folder).st_dev
    except OSError:
        return NOWHERE
    return hashlib.blake2b(f"{kernel} {device}".encode(), digest_size=4).hexdigest()


@cache
def _kernel() -> str:
    """Return a name of this kernel that changes each time it starts; "" where it has none."""
    with suppress(OSError), open("/proc/sys/kernel/random/boot_id", encoding="ascii") as file:
        return file.read().strip()
    with suppress(OSError, subprocess.SubprocessError):  # macOS
        command = ["/usr/sbin/sysctl", "-n", "kern.bootsessionuuid"]
        return subprocess.run(command, capture_output=True, text=True, timeout=5, check=True).stdout.strip()
    return ""
