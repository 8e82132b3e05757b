"""Find the servers that a host has started, and end them (Linux: /proc)."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path


def children(parent: int | None = None) -> list[int]:
    """Return the children of a process, this one by default, that are still at work."""
    found = []
    for folder in Path("/proc").iterdir():
        if not folder.name.isdigit():
            continue
        try:
            state, above = (folder / "stat").read_text().rpartition(")")[2].split()[:2]
            words = (folder / "cmdline").read_bytes()
        except OSError:
            continue
        if int(above) == (parent or os.getpid()) and state != "Z" and (b"flowabs_nodes\0serve" in words):
            found.append(int(folder.name))
    return found


def kill(process: int) -> None:
    """End a process at once."""
    os.kill(process, signal.SIGKILL)


def wait_until(true, seconds: float = 20.0) -> bool:
    """Wait until a function returns something true; return whether it did in time."""
    until = time.monotonic() + seconds
    while not true():
        if time.monotonic() > until:
            return False
        time.sleep(0.01)
    return True


def open_files() -> int:
    """Return how many files this process has open."""
    return len(os.listdir("/proc/self/fd"))


def left_in_memory(process: int | None = None) -> list[str]:
    """Return the names in /dev/shm that a host has left."""
    return [name for name in os.listdir("/dev/shm") if name.startswith(f"flowabs-{process or os.getpid()}-")]
