"""Rows of a picture shared among threads.

Kernels are single-threaded functions of a band of rows, free of the interpreter lock: that compiles in half the time of
numba's own ``parallel=True`` and needs no threading layer, so that several Python threads may run kernels at once. Each
row of a result is worked out by one thread, in one order, so their number never changes a bit.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from functools import cache
from pathlib import Path
from typing import Any

_BANDS = 8  # for each thread: some end later than others

_limit: ContextVar[int | None] = ContextVar("flowabs_threads", default=None)


def thread_count() -> int:
    """How many threads a kernel uses: the limit in force, or else all."""
    limit = _limit.get()
    return available_threads() if limit is None else limit


@cache
def available_threads() -> int:
    """``NUMBA_NUM_THREADS`` of the environment, or else the processors that this process may use."""
    given = os.environ.get("NUMBA_NUM_THREADS", "")
    if given.isdecimal() and int(given) > 0:
        return int(given)
    if hasattr(os, "process_cpu_count"):  # Python 3.13
        processors = os.process_cpu_count()
    else:
        processors = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return max(1, math.ceil(min(processors or 1, _granted())))


def _granted(groups: Path = Path("/sys/fs/cgroup"), own: Path = Path("/proc/self/cgroup")) -> float:
    """How many processors' time a container's limit leaves: the least of its control group and those it is in."""
    try:
        memberships = [line.split(":", 2)[1:] for line in own.read_text(encoding="utf-8").splitlines()]
    except OSError:
        return math.inf
    granted = math.inf
    for controllers, path in memberships:
        if not controllers or "cpu" in controllers.split(","):  # version 2, or version 1
            group = (groups / "cpu" if controllers else groups) / path.lstrip("/")
            granted = min(granted, *map(_quota, (group, *group.parents)))
    return granted


def _quota(group: Path) -> float:
    for names in (["cpu.max"], ["cpu.cfs_quota_us", "cpu.cfs_period_us"]):
        with suppress(OSError, ValueError):  # no such file; "max"
            quota, period = " ".join((group / name).read_text(encoding="utf-8") for name in names).split()
            if float(quota) > 0:
                return float(quota) / float(period)
    return math.inf


@contextmanager
def limited(threads: int) -> Iterator[None]:
    """Kernels called inside, by this thread, use ``threads`` threads, at least 1."""
    token = _limit.set(max(1, threads))
    try:
        yield
    finally:
        _limit.reset(token)


def over_rows(kernel: Callable[..., Any], height: int, *arguments: Any, least: int = 8) -> list[Any]:
    """``kernel(first, last, *arguments)`` for bands that together are the rows 0 .. height - 1.

    Bands have ``least`` rows or more. Returns what the kernel returned, in the order of the bands; how many there are
    depends on the number of threads, so only what does not care (a maximum, a count) may be made of it.
    """
    threads = thread_count()
    bands = 1 if threads == 1 else max(1, min(_BANDS * threads, height // least))
    edges = [height * band // bands for band in range(bands + 1)]
    results: list[Any] = [None] * bands
    waiting = iter(range(bands))  # taking the next is one step of the interpreter: no band is taken twice

    def work() -> None:
        for band in waiting:
            results[band] = kernel(edges[band], edges[band + 1], *arguments)

    helpers = [_pool(os.getpid(), threads - 1).submit(work) for _ in range(min(threads, bands) - 1)]
    try:
        work()
    finally:
        for _ in waiting:  # after an error the other bands need not begin
            pass
        begun = [helper for helper in helpers if not helper.cancel()]  # the others are busy elsewhere
        wait(begun)
    for helper in begun:
        helper.result()
    return results


@cache
def _pool(process: int, threads: int) -> ThreadPoolExecutor:
    """Kept from call to call. ``process``: after a fork the threads are gone."""
    return ThreadPoolExecutor(threads, thread_name_prefix="flowabs")
