"""The pixels beside another id, and what is around them of their own id.

At an object's border passes may disagree: one has a sample a pixel, another the majority of many. What belongs to the
object is told by the pixels of its own id around. There are few such pixels: they are found once, as a list.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Int32, Int64, Uint32
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, set_lanes
from flowabs_nodes.simd.memory import address, load


def id_borders(ids: Uint32) -> Int64:
    """Return the indices of the pixels of a picture (H, W) that have another id within 3x3, in order."""
    return np.concatenate(over_rows(_find, ids.shape[0], ids, ids.reshape(-1).view(np.int32)))


@inlined
def around_own(picture: npt.NDArray[Any], ids: Uint32, y: int, x: int, near: npt.NDArray[Any]) -> int:
    """Write what the up to eight pixels around (x, y) that have its id have in ``picture``; return how many."""
    count = 0
    for j in range(max(y - 1, 0), min(y + 2, ids.shape[0])):
        for i in range(max(x - 1, 0), min(x + 2, ids.shape[1])):
            if ids[j, i] == ids[y, x] and not (j == y and i == x):
                near[count] = picture[j, i]
                count += 1
    return count


@kernel
def _find(first: int, last: int, ids: Uint32, flat: Int32) -> Int64:
    """Return the indices of the pixels beside another id in the rows ``first`` .. ``last`` - 1."""
    height, width = ids.shape
    found, count = np.empty(256, np.int64), 0
    picture = address(flat, 0)
    for y in range(first, last):
        x = 0
        while x < width:
            inside = x >= 1 and x + LANES < width and y >= 1 and y + 1 < height
            end = x + LANES if inside else x + 1
            beside = 1
            if inside:
                pixel = y * width + x
                own = load(picture, pixel)
                change = own ^ own
                for row in range(pixel - width, pixel + width + 1, width):
                    change = change | (own ^ load(picture, row - 1)) | (own ^ load(picture, row))
                    change = change | (own ^ load(picture, row + 1))
                beside = set_lanes((change > 0) | (change < 0))
            elif _one_id(ids, y, x):
                beside = 0
            while beside:
                if beside & 1:
                    if count == found.size:
                        grown = np.empty(2 * count, np.int64)
                        grown[:count] = found
                        found = grown
                    found[count] = y * width + x
                    count += 1
                beside, x = beside >> 1, x + 1
            x = end
    return found[:count].copy()


@inlined
def _one_id(ids: Uint32, y: int, x: int) -> bool:
    """Return whether all pixels around one have its id."""
    for j in range(max(y - 1, 0), min(y + 2, ids.shape[0])):
        for i in range(max(x - 1, 0), min(x + 2, ids.shape[1])):
            if ids[j, i] != ids[y, x]:
                return False
    return True
