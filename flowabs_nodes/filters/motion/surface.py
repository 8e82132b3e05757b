"""What tells surfaces apart from frame to frame: the depth and the normal of each pixel, side by side."""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters.background import BACKGROUND, FAR
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, Floats, select, splat_floats
from flowabs_nodes.simd.memory import load, load_triples, store_quads


def surfaces(normal: Array, depth: Array, stride: int) -> Array:
    """Return normals (H x stride x 3,) and depths (H x stride,) as records of four floats, flattened.

    Depths are as they are :func:`known`. Of the two one may have no pixels: its numbers are the same everywhere then.
    Without both there are no records.
    """
    pixels = max(normal.size // 3, depth.size)
    records = np.empty(4 * pixels, np.float32)
    over_rows(_pack, pixels // stride, normal, depth, stride, records)
    return records


@inlined
def known(z: Floats) -> Floats:
    """Return depths with one number, 1e10, for all that is background: from 1e9 on, Inf and NaN."""
    return select(z < BACKGROUND, z, splat_floats(FAR))


@kernel
def _pack(first: int, last: int, normal: Array, depth: Array, stride: int, records: Array) -> None:
    """Write the records of the rows ``first`` .. ``last`` - 1."""
    u = v = w = splat_floats(0.0)
    z = splat_floats(1.0)
    for y in range(first, last):
        for x0 in range(0, stride, LANES):
            pixel = y * stride + min(x0, stride - LANES)
            if normal.size > 0:
                u, v, w = load_triples(normal, 3 * pixel)
            if depth.size > 0:
                z = known(load(depth, pixel))
            store_quads(records, 4 * pixel, (u, v, w, z))
