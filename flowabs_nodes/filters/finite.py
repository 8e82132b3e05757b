"""Whether all numbers of an array are finite, asked once of each array.

Filters are used to arrays of any origin and look at every pixel first. In the engine one picture goes through many
filters: inside of :func:`remembered` an array that was found finite is not looked at again, nor is one that a kernel
has vouched for (:func:`vouch`).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
import numpy.typing as npt

from flowabs_nodes.filters.kernels import kernel
from flowabs_nodes.filters.pointwise import doubt, doubtful, first_of, over_pixels
from flowabs_nodes.filters.vector import LANES, load, same_floats

Array = npt.NDArray[np.float32]

#: Arrays that are finite, by their identity: those that own their memory, since views come and go.
_known: ContextVar[WeakValueDictionary[int, Array] | None] = ContextVar("flowabs_finite", default=None)


@contextmanager
def remembered() -> Iterator[None]:
    """Inside, no array is looked at twice: it must not be changed there."""
    token = _known.set(WeakValueDictionary())
    try:
        yield
    finally:
        _known.reset(token)


def vouch(array: Array) -> Array:
    """``array``, which is finite for certain."""
    known = _known.get()
    if known is not None:
        owner = _owner(array)
        keeper = owner if owner.size == array.size else array
        known[id(keeper)] = keeper
    return array


def is_finite(array: Array) -> bool:
    """Whether no number of a C-contiguous float32 array is NaN or Inf."""
    known = _known.get()
    if known is not None and any(known.get(id(each)) is each for each in (array, _owner(array))):
        return True
    if array.size < LANES:
        found = bool(np.isfinite(array).all())
    else:
        run = array.reshape(-1)
        found = not any(over_pixels(_not_finite, run.size, run))
    if found:
        vouch(array)
    return found


def _owner(array: Any) -> Any:
    """The array whose memory this is."""
    return array.base if isinstance(array.base, np.ndarray) and array.base.dtype == array.dtype else array


@kernel
def _not_finite(first: int, last: int, numbers: Any) -> Any:
    total = same_floats(0.0)
    for block in range(first, last):
        total = total + doubt(load(numbers, first_of(block, numbers.size)))
    return doubtful(total)
