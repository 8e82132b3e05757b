"""Repeating a picture's border: a pixel beyond the picture has the value of the nearest pixel inside."""

from __future__ import annotations

from flowabs_nodes.array_types import Array
from flowabs_nodes.simd.jit import inlined


@inlined
def repeat_left(row: Array, begin: int, margin: int, channels: int) -> None:
    """Write copies of the first pixel of a row to the ``margin`` pixels before it.

    ``row`` is a 1-D array in which that first pixel takes the ``channels`` items from row[begin] on.
    """
    for k in range(1, margin * channels + 1):
        row[begin - k] = row[begin - k + channels]


@inlined
def repeat_right(row: Array, end: int, margin: int, channels: int) -> None:
    """Write copies of the last pixel of a row to the ``margin`` pixels after it.

    ``row`` is a 1-D array in which that last pixel takes the ``channels`` items up to row[end - 1].
    """
    for k in range(margin * channels):
        row[end + k] = row[end + k - channels]
