"""Searching what is near a place, among points in order of their rows, and of x in each row.

Whoever goes through the points of a row in that order finds the first one of each row around a little further on than
the last time. Where that was is kept: a search costs what there is to pass over.
"""

from __future__ import annotations

from flowabs_nodes.array_types import Float64, Int64
from flowabs_nodes.simd.jit import inlined

#: How far a point may have been moved from where it was when points were put in order.
MOVED = 1.0


@inlined
def begin_rows(rows: Int64, y: int, reach: int, begins: Int64) -> int:
    """Let the searches from the points of row y begin, which look ``reach`` rows up and down; return the top row.

    ``begins`` has an item for each of 2 ``reach`` + 1 rows; there may be fewer in the picture.
    """
    top = max(y - reach, 0)
    for j in range(top, min(y + reach + 1, rows.size - 1)):
        begins[j - top] = rows[j]
    return top


@inlined
def begin_at(begins: Int64, row: int, end: int, xs: Float64, x: float) -> int:
    """Return the index of the first point, before ``end``, of a row that may have an x of at least ``x``.

    ``row`` is counted from the top row of ``begins``. From call to call x may only grow, but for what points are moved.
    """
    first: int = begins[row]
    while first < end and xs[first] < x - MOVED:
        first += 1
    begins[row] = first
    return first
