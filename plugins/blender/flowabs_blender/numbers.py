"""Turns the 32-bit numbers of Blender's properties into the numbers that people meant."""

from __future__ import annotations

import math

import numpy as np

INT_MIN, INT_MAX = -(2**31), 2**31 - 1


def shortest(number: float) -> float:
    """Return the number with the fewest digits among those with the same float32: 0.1 for 0.10000000149."""
    return float(str(np.float32(number)))


def as_float32(number: float) -> float:
    """Return what a float property or a keyframe holds of a number; infinite where it is too large for a float32."""
    with np.errstate(over="ignore"):
        return float(np.float32(number))


def just_above(number: float) -> float:
    """Return the smallest float32 above a number, the minimum of a parameter whose own minimum is excluded."""
    return float(np.nextafter(np.float32(number), np.float32(math.inf)))


def within_int(number: float) -> int:
    """Return a whole number in the range of Blender's int properties, the nearest end where it is beyond."""
    return int(max(INT_MIN, min(INT_MAX, number)))


def is_number(value: object) -> bool:
    """Return whether a value of a graph file is a number that a float32 can hold."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    try:
        return math.isfinite(as_float32(float(value)))
    except OverflowError:
        return False
