"""Arrays that are known to hold nothing but finite numbers.

Filters take arrays of any origin and look at every number first. In the engine one picture goes through many filters:
inside of :func:`remember_finite`, an array that was found finite, or that a kernel vouches for, is not looked at again.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any
from weakref import WeakValueDictionary

import numpy as np

from flowabs_nodes.array_types import Array

_known: ContextVar[WeakValueDictionary[int, Array] | None] = ContextVar("flowabs_vouched", default=None)


@contextmanager
def remember_finite() -> Iterator[None]:
    """Inside, no array is looked at twice, so none may be changed."""
    token = _known.set(WeakValueDictionary())
    try:
        yield
    finally:
        _known.reset(token)


def mark_finite(array: Array) -> Array:
    """``array``, which is finite for certain."""
    known = _known.get()
    if known is not None:
        owner = _owner(array)
        keeper = owner if owner.size == array.size else array  # views come and go, and then know nothing
        known[id(keeper)] = keeper
    return array


def is_marked_finite(array: Array) -> bool:
    """Whether the array, or the one whose memory it shows, is known to be finite."""
    known = _known.get()
    return known is not None and any(known.get(id(each)) is each for each in (array, _owner(array)))


def _owner(array: Any) -> Any:
    """The array whose memory this is."""
    return array.base if isinstance(array.base, np.ndarray) and array.base.dtype == array.dtype else array
