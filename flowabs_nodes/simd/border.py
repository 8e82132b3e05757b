"""The border of a picture, repeated: what lies beyond it is read as the nearest pixel."""

from __future__ import annotations

from typing import Any

from flowabs_nodes.simd.jit import inlined


@inlined
def repeat_left(row: Any, begin: int, margin: int, channels: int) -> None:
    """Write the pixel of ``channels`` items at row[begin] ``margin`` times to the left of it."""
    for k in range(1, margin * channels + 1):
        row[begin - k] = row[begin - k + channels]


@inlined
def repeat_right(row: Any, end: int, margin: int, channels: int) -> None:
    """Write the pixel of ``channels`` items that ends before row[end] ``margin`` times to the right of it."""
    for k in range(margin * channels):
        row[end + k] = row[end + k - channels]
