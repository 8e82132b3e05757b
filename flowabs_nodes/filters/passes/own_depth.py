"""Depth that agrees with the ids: at an object's border the depth pass may show the object next to it.

A depth pass holds one sample a pixel, an id the majority of many. Where a pixel's depth is not that of its own object
around it, it is replaced.
"""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array, Int64, Uint32
from flowabs_nodes.filters.passes.affine_depth import Depth
from flowabs_nodes.filters.passes.id_borders import around_own
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel

_PASSES = 2  # a pixel whose neighbours are wrong too is reached by the second
_AGREES = 0.02  # relative to the median
_AT_ONCE = 2**14  # pixels in a band at most


def own_depth(depth: Depth, ids: Uint32, borders: Int64) -> Depth:
    """Return affine depth in which no pixel beside another id differs from the median of its own id within 3x3.

    ``borders`` are these pixels (:func:`~.id_borders.id_borders`). The depth that is given is written to.
    """
    agreeing = np.empty(borders.size, np.float32)
    for _ in range(_PASSES):
        over_rows(_agree, borders.size, depth.u, ids, borders, agreeing, most=_AT_ONCE)
        depth.u.reshape(-1)[borders] = agreeing
    return depth


@kernel
def _agree(first: int, last: int, u: Array, ids: Uint32, borders: Int64, agreeing: Array) -> None:
    """Write the depth of the pixels ``first`` .. ``last`` - 1 of ``borders``."""
    near = np.empty(9, np.float32)
    for k in range(first, last):
        y, x = borders[k] // ids.shape[1], borders[k] % ids.shape[1]
        count = around_own(u, ids, y, x, near) + 1
        own = near[count - 1] = u[y, x]
        _sort(near, count)
        median, nearest, allowed = near[count - 1 - count // 2], near[count - 1], np.float32(_AGREES)
        agreeing[k] = own
        if abs(own - median) > allowed * abs(median):
            agreeing[k] = nearest if nearest > own + allowed * abs(nearest) else median


@inlined
def _sort(numbers: Array, count: int) -> None:
    """Sort the first ``count`` numbers, a few, in place."""
    for k in range(1, count):
        each, i = numbers[k], k
        while i > 0 and numbers[i - 1] > each:
            numbers[i] = numbers[i - 1]
            i -= 1
        numbers[i] = each
