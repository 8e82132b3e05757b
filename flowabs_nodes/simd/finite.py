"""Checking that all numbers of an array are finite, or small enough to be summed."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.known_finite import is_marked_finite, mark_finite
from flowabs_nodes.simd.lanes import LANES, Floats, splat_floats
from flowabs_nodes.simd.memory import load
from flowabs_nodes.simd.pixelwise import any_nan, first_pixel, over_pixels, zero_or_nan

#: How many numbers of the largest size a filter can sum before the sum leaves float32.
ROOM = 2.0**15
#: The largest number that filters sum, to either side of 0: 1.04e34. No light up to 4.5e30 has larger code values.
LARGEST = float(np.finfo(np.float32).max) / ROOM


def is_finite(array: Array) -> bool:
    """Return whether no number of a C-contiguous float32 array is NaN or Inf.

    An array that is known to be finite is not read (:mod:`~flowabs_nodes.simd.known_finite`), and one found finite
    becomes known.
    """
    return _is_below(array, 1.0)


def is_summable(array: Array) -> bool:
    """Return whether every number of an array is finite and at most ``LARGEST``, as :func:`is_finite` does."""
    return _is_below(array, ROOM)


def refuse_non_finite(name: str, array: Array) -> None:
    """Raise an ArgumentError if ``array`` holds NaN or Inf.

    It names the argument ``name``, counts these numbers and says where in the picture the first is.
    """
    bad = ~np.isfinite(array)
    if bad.any():
        message = f"{name}: expected finite pixels, found {bad.sum()} that are NaN or Inf, the first at {_place(bad)}"
        raise ArgumentError(message, parameter=name)


def refuse_enormous(name: str, array: Array) -> None:
    """Raise an ArgumentError if ``array`` holds a number beyond ``LARGEST``, as :func:`refuse_non_finite` does."""
    bad = np.abs(array) > LARGEST
    if bad.any():
        found = f"found {bad.sum()} beyond, the first {array[bad][0]:.3g} at {_place(bad)}"
        raise ArgumentError(f"{name}: expected numbers up to {LARGEST:.3g}, {found}", parameter=name)


def refuse_overflow(name: str, array: Array, result: Array) -> None:
    """Raise an ArgumentError if ``result``, of which each pixel comes from one of ``array``, is not finite.

    Both are (H, W) or (H, W, C). It names the argument ``name``, and says where the first such pixel is, and what.
    """
    refuse_non_finite(name, array)
    bad = np.asarray(~np.isfinite(result.reshape(*array.shape[:2], -1)).all(axis=-1))
    if bad.any():
        first = " ".join(f"{number:.3g}" for number in np.atleast_1d(array[bad][0]))
        found = f"found larger ones in {bad.sum()} pixels, the first {first} at {_place(bad)}"
        raise ArgumentError(f"{name}: expected numbers whose result float32 can hold, {found}", parameter=name)


def _place(bad: npt.NDArray[np.bool_]) -> str:
    """Return in words where the first pixel is that is set in a mask (H, W) or (H, W, C)."""
    where = np.argwhere(bad)[0]
    return f"x {where[1]}, y {where[0]}" if bad.ndim > 1 else f"index {where[0]}"


def _is_below(array: Array, room: float) -> bool:
    """Return whether every number of an array times ``room`` is finite."""
    if is_marked_finite(array):
        return True
    if array.size < LANES:
        with np.errstate(over="ignore"):
            found = bool(np.isfinite(array * np.float32(room)).all())
    else:
        numbers = array.reshape(-1)
        found = not any(over_pixels(_not_finite, numbers.size, numbers, np.float32(room)))
    if found:
        mark_finite(array)
    return found


@kernel
def _not_finite(first: int, last: int, numbers: Array, room: float) -> bool:
    """Return whether of the blocks first .. last - 1 of sixteen ``numbers`` one is not finite, or not times ``room``.

    ``numbers`` is 1-D float32.
    """
    total = splat_floats(0.0)
    for block in range(first, last):
        total = total + zero_or_nan(load(numbers, first_pixel(block, numbers.size)) * room)
    found: bool = any_nan(total)
    return found


@inlined
def zero_if_summable(x: Floats) -> Floats:
    """Return 0 where x is at most ``LARGEST`` from 0 and NaN where it is not, to be summed as ``zero_or_nan``'s are."""
    return zero_or_nan(x * ROOM)
