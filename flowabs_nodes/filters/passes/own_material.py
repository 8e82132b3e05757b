"""Materials that agree with the ids: at an object's border the material pass may show the object next to it.

Where two objects cover a pixel alike, one pass may take the one and the other the other. Such a pixel would have a
border of materials round it, within an object of one material.
"""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Int32, Uint32
from flowabs_nodes.filters.passes.own_depth import one_id
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES


def own_material(materials: Uint32, ids: Uint32) -> Uint32:
    """Return materials in which each pixel beside another id has the one that most around it of its own id have."""
    agreeing = materials.copy()
    over_rows(_agree, ids.shape[0], materials, ids, ids.reshape(-1).view(np.int32), agreeing)
    return agreeing


@kernel
def _agree(first: int, last: int, materials: Uint32, ids: Uint32, flat_ids: Int32, agreeing: Uint32) -> None:
    """Replace what does not agree in the rows ``first`` .. ``last`` - 1 of ``agreeing``, a copy of ``materials``."""
    height, width = ids.shape
    near = np.empty(8, np.uint32)
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
                        if j == y and i == x:
                            continue
                        around += 1
                        if ids[j, i] == own:
                            near[count] = materials[j, i]
                            count += 1
                if 0 < count < around:
                    agreeing[y, x] = _commonest(near, count, materials[y, x])
                x += 1


@inlined
def _commonest(near: Uint32, count: int, own: int) -> int:
    """Return the number that is most often among the first ``count``, ``own`` where it is as often as any."""
    best, most = own, 0
    for k in range(count):
        if near[k] == own:
            most += 1
    for k in range(count):
        times = 0
        for i in range(count):
            if near[i] == near[k]:
                times += 1
        if times > most:
            best, most = near[k], times
    return best
