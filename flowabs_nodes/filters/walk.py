"""Following the flow (section 3.3): Euler steps of one pixel from the centre, z <- z + t(z), both ways.

The tangent is read at the pixel nearest to z, and turned round when it disagrees with the last step: a flow has no
sign. A zero tangent stops the walk, z stays where it is. Walks go on past the border, along the tangents of the
border.

Offsets from the centre are summed in float64. What rounding decides is then what exact arithmetic on the float32
tangents would decide; and the products of two of those are exact, so that the sign of a dot product is right.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from flowabs_nodes.filters.blocks import Block, first_pixel, inline, scratch, u
from flowabs_nodes.filters.sampling import nearest, read_tangents


class Walk(NamedTuple):
    """Where the walks of a block are."""

    dx: Any  # z - x, the offset from the centre
    dy: Any
    pixel: Any  # nearest to z
    tx: Any  # t(z), the way the walk goes on
    ty: Any
    tangents: Any  # t(z) as it was read


@inline
def new_walk() -> Walk:
    return Walk(
        scratch(np.float64, 1),
        scratch(np.float64, 1),
        scratch(np.int32, 1),
        scratch(np.float32, 1),
        scratch(np.float32, 1),
        scratch(np.float32, 2),
    )


@inline
def start(walk: Walk, flow: Any, way: int, block: Block) -> None:
    """Put the walks at their centres, to go along the tangent there (``way`` 0) or against it (1)."""
    first = u(2) * first_pixel(block)
    for i in range(block.size):
        tx, ty = flow[first + u(2) * i], flow[first + u(2) * i + u(1)]
        walk.dx[i] = 0.0
        walk.dy[i] = 0.0
        walk.pixel[i] = first_pixel(block) + i
        walk.tx[i] = tx if way == 0 else -tx
        walk.ty[i] = ty if way == 0 else -ty


@inline
def step(walk: Walk, flow: Any, block: Block) -> None:
    """One step further: new offsets, the nearest pixel, and the tangent there, turned to go on the same way."""
    for i in range(block.size):
        walk.dx[i] += np.float64(walk.tx[i])
        walk.dy[i] += np.float64(walk.ty[i])
    nearest(walk.dx, walk.dy, walk.pixel, block)
    read_tangents(flow, walk.pixel, walk.tangents, block)
    for i in range(block.size):
        tx, ty = walk.tangents[u(2) * i], walk.tangents[u(2) * i + u(1)]
        against = np.float64(tx) * np.float64(walk.tx[i]) + np.float64(ty) * np.float64(walk.ty[i]) < 0.0
        walk.tx[i] = -tx if against else tx
        walk.ty[i] = -ty if against else ty
