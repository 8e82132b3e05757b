"""Rows of a picture shared among threads.

Kernels are single-threaded functions of a band of rows, free of the interpreter lock: that compiles in half the time of
numba's own ``parallel=True`` and needs no threading layer, so that several Python threads may run kernels at once. Each
row of a result is worked out by one thread, in one order, so their number never changes a bit.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from typing import Any

_BANDS = 8  # for each thread: some end later than others

_limit: ContextVar[int | None] = ContextVar("flowabs_threads", default=None)


def count() -> int:
    """How many threads a kernel uses: the limit in force, or else all."""
    limit = _limit.get()
    return every() if limit is None else limit


@cache
def every() -> int:
    """``NUMBA_NUM_THREADS`` of the environment, or else the processors that this process may use."""
    given = os.environ.get("NUMBA_NUM_THREADS", "")
    if given.isdecimal() and int(given) > 0:
        return int(given)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def limited(threads: int) -> Iterator[None]:
    """Kernels called inside use no more than ``threads`` threads, at least 1."""
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
    threads = count()
    bands = 1 if threads == 1 else max(1, min(_BANDS * threads, height // least))
    edges = [height * band // bands for band in range(bands + 1)]
    results: list[Any] = [None] * bands
    waiting = iter(range(bands))  # taking the next is one step of the interpreter: no band is taken twice

    def work() -> None:
        for band in waiting:
            results[band] = kernel(edges[band], edges[band + 1], *arguments)

    helpers = [_pool(os.getpid(), threads - 1).submit(work) for _ in range(min(threads, bands) - 1)]
    work()
    for helper in helpers:
        helper.result()
    return results


@cache
def _pool(process: int, threads: int) -> ThreadPoolExecutor:
    """Kept from call to call. ``process``: after a fork the threads are gone."""
    return ThreadPoolExecutor(threads, thread_name_prefix="flowabs")
