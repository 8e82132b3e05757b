"""Lend the OpenEXR module threads for as long as it encodes.

Its threads are one pool of the whole process, none unless somebody asks for them. A child of a fork gets the pool
without the threads, and whatever it encoded would wait for them for ever. So the pool is empty while nobody encodes,
and a fork waits for who does (:mod:`flowabs_nodes.forks`).
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

import OpenEXR

from flowabs_nodes import forks
from flowabs_nodes.simd.bands import thread_count

_turn = threading.Lock()
forks.take_before(_turn)


@contextmanager
def encoding_threads() -> Iterator[None]:
    """Inside, OpenEXR encodes with as many threads as kernels use (:func:`~flowabs_nodes.simd.bands.thread_count`).

    One picture is encoded at a time, but for those with one thread. A pool that somebody else has filled is left alone.
    """
    threads = thread_count()
    if threads == 1:
        yield
        return
    with _turn:
        if OpenEXR.global_thread_count():
            yield
            return
        OpenEXR.set_global_thread_count(threads)
        try:
            yield
        finally:
            OpenEXR.set_global_thread_count(0)
