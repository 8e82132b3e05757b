"""Searching points on edges near a place."""

from __future__ import annotations

from flowabs_nodes.filters.passes.edges import Edges
from flowabs_nodes.simd.jit import inlined

#: How far a point may have been moved from where it was when points were put in order.
MOVED = 1.0


@inlined
def begin_at(edges: Edges, y: int, x: float) -> int:
    """Return the index of the first point of row y that may have an x of at least ``x``."""
    low: int = edges.rows[y]
    high: int = edges.rows[y + 1]
    while low < high:
        middle = (low + high) // 2
        if edges.x[middle] < x - MOVED:
            low = middle + 1
        else:
            high = middle
    return low
