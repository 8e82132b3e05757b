from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeVar

import numba
import pytest

Result = TypeVar("Result")


@pytest.fixture
def each_thread_count() -> Iterator[Callable[[Callable[[], Result]], list[Result]]]:
    """Run a function on one thread, then on as many as there are, at most three; a list of what it returned."""
    before = numba.get_num_threads()

    def run(function: Callable[[], Result]) -> list[Result]:
        results = []
        for threads in range(1, min(numba.config.NUMBA_NUM_THREADS, 3) + 1):
            numba.set_num_threads(threads)
            results.append(function())
        numba.set_num_threads(before)
        return results

    yield run
    numba.set_num_threads(before)
