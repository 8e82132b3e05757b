"""Whether all numbers of an array are finite."""

from __future__ import annotations

from typing import Any

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.known_finite import is_marked_finite, mark_finite
from flowabs_nodes.simd.lanes import LANES, splat_floats
from flowabs_nodes.simd.memory import load
from flowabs_nodes.simd.pixelwise import any_nan, first_pixel, over_pixels, zero_or_nan


def is_finite(array: Array) -> bool:
    """Whether no number of a C-contiguous float32 array is NaN or Inf; in the engine each is looked at once."""
    if is_marked_finite(array):
        return True
    if array.size < LANES:
        found = bool(np.isfinite(array).all())
    else:
        run = array.reshape(-1)
        found = not any(over_pixels(_not_finite, run.size, run))
    if found:
        mark_finite(array)
    return found


def refuse_non_finite(name: str, array: Array) -> None:
    """Raise ArgumentError that names the argument and counts its numbers that are NaN or Inf, if there are any."""
    bad = int(array.size - np.isfinite(array).sum())
    if bad:
        raise ArgumentError(f"{name}: expected finite pixels, found {bad} that are NaN or Inf", parameter=name)


@kernel
def _not_finite(first: int, last: int, numbers: Any) -> Any:
    total = splat_floats(0.0)
    for block in range(first, last):
        total = total + zero_or_nan(load(numbers, first_pixel(block, numbers.size)))
    return any_nan(total)
