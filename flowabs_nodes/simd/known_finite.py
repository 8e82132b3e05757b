"""Remembering which arrays are known to hold only finite numbers.

Filters take arrays of any origin and check every number first. In the engine one picture goes through many filters.
Inside :func:`remember_finite`, an array that a check found finite, or that a filter marked as finite because its kernel
writes nothing else, is not checked again.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from weakref import WeakValueDictionary

import numpy as np

from flowabs_nodes.array_types import Array

_known: ContextVar[WeakValueDictionary[int, Array] | None] = ContextVar("flowabs_known_finite", default=None)


@contextmanager
def remember_finite() -> Iterator[None]:
    """Check no array twice inside. Arrays that were checked must not be changed there."""
    token = _known.set(WeakValueDictionary())
    try:
        yield
    finally:
        _known.reset(token)


def mark_finite(array: Array) -> Array:
    """Return ``array``, remembered as one that holds only finite numbers."""
    known = _known.get()
    if known is not None:
        owner = _owner(array)
        keeper = owner if owner.size == array.size else array  # the view may be gone when its owner is checked
        known[id(keeper)] = keeper
    return array


def is_marked_finite(array: Array) -> bool:
    """Return whether ``array``, or the array that owns its memory, is known to hold only finite numbers."""
    known = _known.get()
    return known is not None and any(known.get(id(each)) is each for each in (array, _owner(array)))


def _owner(array: Array) -> Array:
    """Return the array of the same dtype that owns the memory of ``array``, or else ``array`` itself."""
    return array.base if isinstance(array.base, np.ndarray) and array.base.dtype == array.dtype else array
