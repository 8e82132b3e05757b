"""Measures memory: what the machine or its control group gives, and what processes of a run have taken."""

from __future__ import annotations

import ctypes
import os
import re
import sys
from contextlib import suppress
from pathlib import Path

_UNITS = {"": 1, "B": 1, "K": 10**3, "M": 10**6, "G": 10**9, "T": 10**12}

#: How much of what there is a run takes unless it is told.
SHARE = 0.8


def parse_memory(text: str | int) -> int:
    """Return how many bytes a text such as "16GB", "900M", "1.5GiB" or "50%" (of what there is) stands for.

    Raises ValueError for any other text, and for less than a megabyte.
    """
    match = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*(?:(%)|([KMGT]?)(i?)B?)\s*", str(text), re.IGNORECASE)
    if match is None:
        raise ValueError(f"expected a size such as 16GB, 900M or 50%, found {text!r}")
    number, percent, unit, binary = match.groups()
    if percent:
        size = float(number) / 100 * available_memory()
    else:
        size = float(number) * (1024 ** "BKMGT".index((unit or "B").upper()) if binary else _UNITS[unit.upper()])
    if size < 1e6:
        raise ValueError(f"expected at least a megabyte, found {text!r}")
    return int(size)


def available_memory(
    groups: Path = Path("/sys/fs/cgroup"), own: Path = Path("/proc/self/cgroup"), of_machine: int | None = None
) -> int:
    """Return how many bytes this process may use at most: those of the machine, or of the tightest control group.

    ``groups`` is the folder of all control groups, ``own`` the file that lists those of this process (Linux).
    """
    least = _memory_of_machine() if of_machine is None else of_machine
    try:
        memberships = [line.split(":", 2)[1:] for line in own.read_text(encoding="utf-8").splitlines()]
    except OSError:
        return least
    for controllers, path in memberships:
        if not controllers or "memory" in controllers.split(","):  # version 2, or version 1
            group = (groups / "memory" if controllers else groups) / path.lstrip("/")
            for place in (group, *group.parents):
                for name in ("memory.max", "memory.limit_in_bytes"):
                    with suppress(OSError, ValueError):  # no such file; "max"
                        least = min(least, int((place / name).read_text(encoding="utf-8")))
    return least


def _memory_of_machine() -> int:
    """Return the bytes of memory that the machine has."""
    if sys.platform == "win32":
        state = _WindowsMemory(ctypes.sizeof(_WindowsMemory))
        ctypes.windll.kernel32.GlobalMemoryStatusEx(ctypes.byref(state))
        return int(state.total)
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


class _WindowsMemory(ctypes.Structure):
    """MEMORYSTATUSEX of the Windows API."""

    _fields_ = (
        ("length", ctypes.c_uint32),
        ("load", ctypes.c_uint32),
        ("total", ctypes.c_uint64),
        ("rest", ctypes.c_uint64 * 6),
    )


def reset_peak() -> None:
    """Have :func:`peak_since_reset` count from now on, where the system can (Linux)."""
    with suppress(OSError), open("/proc/self/clear_refs", "w", encoding="ascii") as file:
        file.write("5")


def peak_since_reset() -> int:
    """Return the most memory in bytes that this process had since :func:`reset_peak`, or since it began; 0: unknown."""
    with suppress(OSError), open("/proc/self/status", encoding="ascii", errors="replace") as file:
        for line in file:
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * 1024
    if sys.platform == "win32":
        return 0
    import resource

    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else most * 1024


def resident() -> int:
    """Return how much memory in bytes this process has now (Linux), or at most has had (elsewhere)."""
    with suppress(OSError), open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    return peak_since_reset()


def give_back_freed_memory() -> None:
    """Hand memory that has been freed back to the system, where its C library keeps it (glibc)."""
    if sys.platform == "linux":
        with suppress(OSError, AttributeError):
            ctypes.CDLL(None).malloc_trim(0)
