"""Materials that agree with the ids: at an object's border the material pass may show the object next to it.

Where two objects cover a pixel alike, one pass may take the one and the other the other. Such a pixel would have a
border of materials round it, within an object of one material.
"""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Int64, Uint32
from flowabs_nodes.filters.passes.id_borders import around_own
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel

_AT_ONCE = 2**14  # pixels in a band at most


def own_material(materials: Uint32, ids: Uint32, borders: Int64) -> Uint32:
    """Return materials in which each pixel beside another id has the one that most around it of its own id have.

    ``borders`` are these pixels (:func:`~.id_borders.id_borders`).
    """
    agreeing = materials.copy()
    over_rows(_agree, borders.size, materials, ids, borders, agreeing, most=_AT_ONCE)
    return agreeing


@kernel
def _agree(first: int, last: int, materials: Uint32, ids: Uint32, borders: Int64, agreeing: Uint32) -> None:
    """Write the material of the pixels ``first`` .. ``last`` - 1 of ``borders``."""
    near = np.empty(8, np.uint32)
    for k in range(first, last):
        y, x = borders[k] // ids.shape[1], borders[k] % ids.shape[1]
        count = around_own(materials, ids, y, x, near)
        agreeing[y, x] = _commonest(near, count, materials[y, x])


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
