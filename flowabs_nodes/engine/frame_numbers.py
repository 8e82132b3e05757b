"""Reads the frame numbers that Python code hands over: Python's whole numbers, NumPy's, and arrays of them."""

from __future__ import annotations

import operator
from collections.abc import Iterable
from typing import Any

from flowabs_nodes.errors import ArgumentError, CommandError
from flowabs_nodes.io.sequences import parse_frames


def whole_number(value: Any) -> int | None:
    """Return a whole number of Python or NumPy as an int; None for anything else, such as 1.0, "1" and True."""
    if isinstance(value, bool) or getattr(value, "ndim", None):  # an array of one number is a list of numbers
        return None
    try:
        return operator.index(value)
    except TypeError:
        return None


def frame_number(value: Any, parameter: str = "frame") -> int:
    """Return the number of one frame; raise ArgumentError, which names the ``parameter``, for anything else."""
    number = whole_number(value)
    if number is None:
        raise ArgumentError(
            f"{parameter}: expected a whole number, found {value!r}", code="wrong-type", parameter=parameter
        )
    return number


def frame_numbers(frames: Any) -> tuple[int, ...]:
    """Return the frames of a range (``"1001-1100x2,1200"``), of one number or of several; each once, in their order.

    Raises CommandError where the text is no range, or there are other things than whole numbers, or none at all.
    """
    if isinstance(frames, str):
        return parse_frames(frames)
    one = whole_number(frames)
    if one is not None:
        return (one,)
    several = isinstance(frames, Iterable) and not isinstance(frames, bytes) and getattr(frames, "ndim", 1) == 1
    found = list(frames) if several else []
    numbers = [number for number in map(whole_number, found) if number is not None]
    if not found or len(numbers) < len(found):
        wrong = next((each for each in found if whole_number(each) is None), frames)
        raise CommandError(
            f"frames: expected a range such as '1001-1100x2' or whole numbers, found {wrong!r}",
            code="bad-frames",
            parameter="frames",
        )
    return tuple(dict.fromkeys(numbers))
