from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import pytest

from flowabs_nodes.simd import bands

Result = TypeVar("Result")


@pytest.fixture
def each_thread_count() -> Callable[[Callable[[], Result]], list[Result]]:
    """Return a helper that calls a function on one, two and three threads, and lists the three results."""

    def run(function: Callable[[], Result]) -> list[Result]:
        results = []
        for count in range(1, 4):
            with bands.limited(count):
                results.append(function())
        return results

    return run
