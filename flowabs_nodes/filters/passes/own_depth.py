"""Depth that agrees with the ids: at an object's border the depth pass may show the object next to it.

A depth pass holds one sample a pixel, an id the majority of many. Where a pixel's depth is not that of its own object
around it, it is replaced.
"""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array, Int32, Uint32
from flowabs_nodes.filters.passes.affine_depth import Depth
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, any_lane
from flowabs_nodes.simd.memory import load

_PASSES = 2  # a pixel whose neighbours are wrong too is reached by the second
_AGREES = 0.02  # relative to the median


def own_depth(depth: Depth, ids: Uint32) -> Depth:
    """Return affine depth in which no pixel beside another id differs from the median of its own id within 3x3."""
    u = depth.u
    for _ in range(_PASSES):
        agreeing = u.copy()
        over_rows(_agree, u.shape[0], u, ids, ids.reshape(-1).view(np.int32), agreeing)
        u = agreeing
    return depth._replace(u=u)


@kernel
def _agree(first: int, last: int, u: Array, ids: Uint32, flat_ids: Int32, agreeing: Array) -> None:
    """Replace what does not agree in the rows ``first`` .. ``last`` - 1 of ``agreeing``, a copy of ``u``."""
    height, width = u.shape
    near = np.empty(9, np.float32)
    for y in range(first, last):
        x = 0
        while x < width:
            inside = x >= 1 and x + LANES < width and y >= 1 and y + 1 < height
            end = x + LANES if inside else x + 1
            if inside and one_id(flat_ids, y * width + x, width):
                x = end
                continue
            while x < end:
                own, count, around = ids[y, x], 0, 0
                for j in range(max(y - 1, 0), min(y + 2, height)):
                    for i in range(max(x - 1, 0), min(x + 2, width)):
                        around += 1
                        if ids[j, i] == own:
                            near[count] = u[j, i]
                            count += 1
                if count < around:
                    _sort(near, count)
                    median, nearest, allowed = near[count - 1 - count // 2], near[count - 1], np.float32(_AGREES)
                    if abs(u[y, x] - median) > allowed * abs(median):
                        in_front = nearest > u[y, x] + allowed * abs(nearest)
                        agreeing[y, x] = nearest if in_front else median
                x += 1


@inlined
def one_id(ids: Int32, pixel: int, width: int) -> bool:
    """Return whether sixteen pixels, from ``pixel`` on, and all beside them have one id each with those beside it."""
    own = load(ids, pixel)
    others = own ^ own
    for row in range(pixel - width, pixel + width + 1, width):
        for i in range(row - 1, row + 2):
            others = others | (own ^ load(ids, i))
    differ: bool = any_lane(others > 0) or any_lane(others < 0)
    return not differ


@inlined
def _sort(numbers: Array, count: int) -> None:
    """Sort the first ``count`` numbers, a few, in place."""
    for k in range(1, count):
        each, i = numbers[k], k
        while i > 0 and numbers[i - 1] > each:
            numbers[i] = numbers[i - 1]
            i -= 1
        numbers[i] = each
