"""What happens when a kernel has to be compiled, since it was not found on disk."""

from __future__ import annotations

from collections.abc import Callable

#: Called the next time, and then forgotten. This module imports no numba: whoever waits need not either.
waiting: list[Callable[[], None]] = []


def tell() -> None:
    """Call who waits for it: a kernel is about to be compiled."""
    while waiting:
        waiting.pop()()
