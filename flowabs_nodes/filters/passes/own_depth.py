"""Depth that agrees with the ids: at an object's border the depth pass may show the object next to it.

A depth pass holds one sample a pixel, an id the majority of many. Where a pixel's depth is not that of its own object
around it, it is replaced.
"""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters.passes.affine_depth import Depth
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel

_PASSES = 2  # a pixel whose neighbours are wrong too is reached by the second
_AGREES = 0.02  # relative to the median


def own_depth(depth: Depth, ids: Array) -> Depth:
    """Return affine depth in which no pixel beside another id differs from the median of its own id within 3x3."""
    u = depth.u
    for _ in range(_PASSES):
        agreeing = u.copy()
        over_rows(_agree, u.shape[0], u, ids, agreeing)
        u = agreeing
    return depth._replace(u=u)


@kernel
def _agree(first: int, last: int, u: Array, ids: Array, agreeing: Array) -> None:
    """Replace what does not agree in the rows ``first`` .. ``last`` - 1 of ``agreeing``, a copy of ``u``."""
    height, width = u.shape
    near = np.empty(9, np.float32)
    for y in range(first, last):
        for x in range(width):
            own = ids[y, x]
            right, below = min(x + 1, width - 1), min(y + 1, height - 1)
            left, above = max(x - 1, 0), max(y - 1, 0)
            same = ids[y, left] == own and ids[y, right] == own
            same = same and ids[above, x] == own and ids[below, x] == own
            same = same and ids[above, left] == own and ids[above, right] == own
            if same and ids[below, left] == own and ids[below, right] == own:
                continue
            count = 0
            for j in range(above, below + 1):
                for i in range(left, right + 1):
                    if ids[j, i] == own:
                        near[count] = u[j, i]
                        count += 1
            _sort(near, count)
            median, nearest = near[count - 1 - count // 2], near[count - 1]
            allowed = np.float32(_AGREES) * abs(median)
            if abs(u[y, x] - median) > allowed:
                in_front = nearest > u[y, x] + np.float32(_AGREES) * abs(nearest)
                agreeing[y, x] = nearest if in_front else median


@inlined
def _sort(numbers: Array, count: int) -> None:
    """Sort the first ``count`` numbers, a few, in place."""
    for k in range(1, count):
        each, i = numbers[k], k
        while i > 0 and numbers[i - 1] > each:
            numbers[i] = numbers[i - 1]
            i -= 1
        numbers[i] = each
