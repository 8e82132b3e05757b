"""Sharing the rows of a picture among threads.

A compiled kernel is a single-threaded function of a band of rows and releases the interpreter lock. It compiles in half
the time of numba's own ``parallel=True`` and needs no threading layer, so several Python threads may run kernels at
once. Each row of a result is computed by one thread in one order, so the number of threads never changes a bit.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from concurrent.futures import Future, wait
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flowabs_nodes import stopping
from flowabs_nodes.simd.read_only import for_kernel

if TYPE_CHECKING:
    from concurrent.futures import ThreadPoolExecutor

_BANDS = 8  # bands for each thread at least, so that a thread that is done early takes another
_MOST = 32  # rows in a band at most: work that is asked to stop ends after the bands that have begun

_limit: ContextVar[int | None] = ContextVar("flowabs_threads", default=None)


def thread_count() -> int:
    """Return how many threads a kernel uses: the limit of :func:`limited`, or else :func:`available_threads`."""
    limit = _limit.get()
    return available_threads() if limit is None else limit


@cache
def available_threads() -> int:
    """Return ``NUMBA_NUM_THREADS`` of the environment, or else the number of processors this process may use."""
    given = os.environ.get("NUMBA_NUM_THREADS", "")
    if given.isdecimal() and int(given) > 0:
        return int(given)
    if hasattr(os, "process_cpu_count"):  # Python 3.13
        processors = os.process_cpu_count()
    else:
        processors = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return max(1, math.ceil(min(processors or 1, _granted())))


def _granted(groups: Path = Path("/sys/fs/cgroup"), own: Path = Path("/proc/self/cgroup")) -> float:
    """Return how many processors' time the control groups of this process allow, the least of them all (Linux).

    ``groups`` is the folder of all control groups, ``own`` the file that lists those of this process. The result is
    infinite without a limit.
    """
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
    """Return how many processors' time one control group allows, infinite where it sets no limit."""
    for names in (["cpu.max"], ["cpu.cfs_quota_us", "cpu.cfs_period_us"]):
        with suppress(OSError, ValueError):  # no such file; "max"
            quota, period = " ".join((group / name).read_text(encoding="utf-8") for name in names).split()
            if float(quota) > 0:
                return float(quota) / float(period)
    return math.inf


@contextmanager
def limited(threads: int) -> Iterator[None]:
    """Have the kernels that this thread calls inside use ``threads`` threads; less than 1 counts as 1."""
    token = _limit.set(max(1, threads))
    try:
        yield
    finally:
        _limit.reset(token)


def over_rows(kernel: Callable[..., Any], height: int, *arguments: Any, least: int = 8, most: int = _MOST) -> list[Any]:
    """Call ``kernel(first, last, *arguments)`` for bands of rows that together are the rows 0 .. height - 1.

    Parameters
    ----------
    kernel
        A function of the rows ``first`` .. ``last - 1``, called by several threads at once.
    height
        The number of rows.
    arguments
        Further arguments of the kernel. In place of a read-only array the kernel gets a writable view of it
        (:mod:`~flowabs_nodes.simd.read_only`).
    least
        How many rows a band has at least, unless the picture has fewer.
    most
        How many rows a band has at most, where ``least`` allows it.

    Returns
    -------
    The kernel's results in the order of the bands. The number of bands depends on the number of threads, so the caller
    may only combine the results in ways that do not depend on it, such as a maximum.

    Raises :class:`~flowabs_nodes.stopping.Stopped` where the work is asked to stop; no band is at work then.
    """
    stopping.check()
    flags = stopping.flags()
    threads = thread_count()
    bands = max(1, min(max(_BANDS * threads, -(-height // most)), height // least))
    edges = [height * band // bands for band in range(bands + 1)]
    results: list[Any] = [None] * bands
    arguments = tuple(map(for_kernel, arguments))
    waiting = iter(range(bands))  # the interpreter advances it in one step: no two threads take the same band

    def work() -> None:
        """Run the kernel on one waiting band after the other."""
        for band in waiting:
            if stopping.any_set(flags):
                return
            results[band] = kernel(edges[band], edges[band + 1], *arguments)

    helpers = _start_helpers(work, threads - 1, min(threads, bands) - 1)
    try:
        work()
    finally:
        for _ in waiting:  # after an error no further band begins
            pass
        begun = [helper for helper in helpers if not helper.cancel()]  # cancelled: its thread was busy with other work
        wait(begun)
    for helper in begun:
        helper.result()
    stopping.check()
    return results


def _start_helpers(work: Callable[[], None], threads: int, count: int) -> list[Future[None]]:
    """Have ``work`` called by ``count`` threads of a pool of ``threads`` beside this one; return what becomes of each.

    Where no thread can be had (the main thread has ended, or the system has no more) there are fewer, or none: whoever
    calls works on its own then.
    """
    helpers: list[Future[None]] = []
    with suppress(RuntimeError):
        for _ in range(count):
            # Made here: a pool that cannot start a thread keeps what it was to do, and may yet do it.
            helpers.append(Future())
            _pool(os.getpid(), threads).submit(_fulfil, helpers[-1], work)
    return helpers


def _fulfil(helper: Future[None], work: Callable[[], None]) -> None:
    """Call ``work`` unless ``helper`` has been cancelled, and note there what became of it."""
    if helper.set_running_or_notify_cancel():
        try:
            work()
            helper.set_result(None)
        except BaseException as error:  # noqa: BLE001 - raised again by whoever asks for the result
            helper.set_exception(error)


@cache
def _pool(process: int, threads: int) -> ThreadPoolExecutor:
    """Return a pool of threads, the same for each call of one ``process``: after a fork the threads are gone."""
    from concurrent.futures import ThreadPoolExecutor  # which Python refuses to import once the main thread has ended

    return ThreadPoolExecutor(threads, thread_name_prefix="flowabs")
