"""Checking that all numbers of an array are finite."""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.known_finite import is_marked_finite, mark_finite
from flowabs_nodes.simd.lanes import LANES, splat_floats
from flowabs_nodes.simd.memory import load
from flowabs_nodes.simd.pixelwise import any_nan, first_pixel, over_pixels, zero_or_nan


def is_finite(array: Array) -> bool:
    """Return whether no number of a C-contiguous float32 array is NaN or Inf.

    An array that is known to be finite is not read (:mod:`~flowabs_nodes.simd.known_finite`), and one found finite
    becomes known.
    """
    if is_marked_finite(array):
        return True
    if array.size < LANES:
        finite = bool(np.isfinite(array).all())
    else:
        numbers = array.reshape(-1)
        finite = not any(over_pixels(_not_finite, numbers.size, numbers))
    if finite:
        mark_finite(array)
    return finite


def refuse_non_finite(name: str, array: Array) -> None:
    """Raise an ArgumentError if ``array`` holds NaN or Inf. It names the argument ``name`` and counts these numbers."""
    bad = int(array.size - np.isfinite(array).sum())
    if bad:
        raise ArgumentError(f"{name}: expected finite pixels, found {bad} that are NaN or Inf", parameter=name)


@kernel
def _not_finite(first: int, last: int, numbers: Array) -> bool:
    """Return whether the blocks first .. last - 1 of sixteen ``numbers`` (1-D float32) hold a NaN or an Inf."""
    total = splat_floats(0.0)
    for block in range(first, last):
        total = total + zero_or_nan(load(numbers, first_pixel(block, numbers.size)))
    found: bool = any_nan(total)
    return found
