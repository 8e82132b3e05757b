from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import pytest

from flowabs_nodes.simd import bands

Result = TypeVar("Result")


@pytest.fixture
def each_thread_count() -> Callable[[Callable[[], Result]], list[Result]]:
    """Run a function on one thread, on two and on three; a list of what it returned."""

    def run(function: Callable[[], Result]) -> list[Result]:
        results = []
        for count in range(1, 4):
            with bands.limited(count):
                results.append(function())
        return results

    return run
