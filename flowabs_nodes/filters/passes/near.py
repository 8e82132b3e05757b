"""Searching what is near a place, among points in order of their rows, and of x in each row."""

from __future__ import annotations

from flowabs_nodes.array_types import Float64, Int64
from flowabs_nodes.simd.jit import inlined

#: How far a point may have been moved from where it was when points were put in order.
MOVED = 1.0


@inlined
def begin_at(rows: Int64, xs: Float64, y: int, x: float) -> int:
    """Return the index of the first point of row y that may have an x of at least ``x``."""
    low: int = rows[y]
    high: int = rows[y + 1]
    while low < high:
        middle = (low + high) // 2
        if xs[middle] < x - MOVED:
            low = middle + 1
        else:
            high = middle
    return low
