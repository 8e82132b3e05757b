"""The edge tangent flow of a render's passes: along its edges, and along the bends of its surfaces between them.

Every point of an edge counts as the tensor s^2 n n^T, spread by a Gaussian of 1 px and multiplied by 3, so that beside
an edge ĝ is 1. Away from edges the gradient of the normals counts, 15 degrees per pixel as full strength. What comes
of it goes through the fill and the passes of eq. 1 as the gradient of a picture does.
"""

from __future__ import annotations

import math

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters.flow import gradient
from flowabs_nodes.filters.flow.etf_passes import smooth
from flowabs_nodes.filters.flow.fill import flow_fill
from flowabs_nodes.filters.flow.footprint_sums import footprint_passes
from flowabs_nodes.filters.passes.edges import FARTHEST, Edges
from flowabs_nodes.filters.passes.near import MOVED
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import kernel

_STEEP = math.radians(15.0)  # of the normals' turn in a pixel: full strength
_CERTAIN = 0.1  # of full strength: weaker bends, down to the noise of a flat face, lean on what is around
_EDGE = 3.0  # what an edge counts
_REACH = 3  # px, of its Gaussian
_ROWS = math.ceil(_REACH + MOVED + FARTHEST) + 1  # where edges are looked for
_LEAST = 0.001  # strength that counts: no tensor is so small that it becomes 0
_INSTEAD = 4.0  # how fast the normals' part fades beside an edge


def passes_flow(edges: Edges, unit: Array | None, shape: tuple[int, int], radius: float, iterations: int) -> Array:
    """Return the ETF of edges and unit normals, (H, W, 2) float32; (1, 0) everywhere without any."""
    if unit is None:
        tangent, magnitude, largest = np.zeros((*shape, 2), np.float32), np.zeros(shape, np.float32), 0.0
    else:
        (tangent, magnitude), largest, _ = gradient.measured(unit)
    over_rows(_with_edges, shape[0], edges, tangent, magnitude)
    tangent = flow_fill(tangent, magnitude, _CERTAIN * _STEEP, max(largest, _STEEP))
    if iterations == 0 or radius <= 1:
        return tangent
    return smooth(tangent, magnitude, _STEEP, iterations, footprint_passes("full", [radius], *shape))


@kernel
def _with_edges(first: int, last: int, edges: Edges, tangent: Array, magnitude: Array) -> None:
    """Lay edges over the gradient of the normals in the rows ``first`` .. ``last`` - 1."""
    height, width = magnitude.shape
    tensor = np.zeros(((last - first) * width, 3), np.float32)
    across = np.empty(2 * _REACH + 1)  # the Gaussian along a row
    beside, count = np.empty((last - first) * width, np.int64), 0  # the pixels that have a tensor
    for e in range(edges.rows[max(first - _ROWS, 0)], edges.rows[min(last + _ROWS, height)]):
        px, py, nx, ny = edges.x[e], edges.y[e], edges.nx[e], edges.ny[e]
        if edges.strength[e] < _LEAST:
            continue
        left, right = max(0, math.ceil(px - _REACH)), min(width, math.floor(px + _REACH) + 1)
        for x in range(left, right):
            across[x - left] = math.exp(-0.5 * (x - px) * (x - px))
        share = _EDGE * edges.strength[e] ** 2 / (2 * math.pi)
        for y in range(max(first, math.ceil(py - _REACH)), min(last, math.floor(py + _REACH) + 1)):
            down = share * math.exp(-0.5 * (y - py) * (y - py))
            for x in range(left, right):
                w = down * across[x - left]
                i = (y - first) * width + x
                if tensor[i, 0] + tensor[i, 2] == 0:
                    beside[count] = i
                    count += 1
                tensor[i, 0] += w * nx * nx
                tensor[i, 1] += w * nx * ny
                tensor[i, 2] += w * ny * ny
    for k in range(count):
        y, x = first + beside[k] // width, beside[k] % width
        xx, xy, yy = (
            np.float64(tensor[beside[k], 0]),
            np.float64(tensor[beside[k], 1]),
            np.float64(tensor[beside[k], 2]),
        )
        m = min(magnitude[y, x] / _STEEP, 1.0)
        of_normals = m * m * max(1 - _INSTEAD * (xx + yy), 0)
        tx, ty = tangent[y, x, 0], tangent[y, x, 1]
        xx, xy, yy = xx + of_normals * ty * ty, xy - of_normals * tx * ty, yy + of_normals * tx * tx
        angle = 0.5 * math.atan2(2 * xy, xx - yy)  # of the major eigenvector, across the edge
        tangent[y, x, 0], tangent[y, x, 1] = -math.sin(angle), math.cos(angle)
        magnitude[y, x] = _STEEP * min(math.sqrt((xx + yy + math.hypot(xx - yy, 2 * xy)) / 2), 1.0)
