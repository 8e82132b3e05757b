from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeVar

import numba
import pytest

from flowabs_nodes.filters import threads

Result = TypeVar("Result")


@pytest.fixture
def each_thread_count() -> Iterator[Callable[[Callable[[], Result]], list[Result]]]:
    """Run a function on one thread, on two and on three; a list of what it returned."""
    before = numba.get_num_threads()

    def run(function: Callable[[], Result]) -> list[Result]:
        results = []
        for count in range(1, 4):
            numba.set_num_threads(min(count, numba.config.NUMBA_NUM_THREADS))
            with threads.limited(count):
                results.append(function())
        numba.set_num_threads(before)
        return results

    yield run
    numba.set_num_threads(before)
