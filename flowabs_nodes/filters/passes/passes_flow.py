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
from flowabs_nodes.filters.passes.edges import Edges
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import kernel

_STEEP = math.radians(15.0)  # of the normals' turn in a pixel: full strength
_CERTAIN = 0.1  # of full strength: weaker bends, down to the noise of a flat face, lean on what is around
_EDGE = 3.0  # what an edge counts
_REACH = 3  # px, of its Gaussian
_INSTEAD = 4.0  # how fast the normals' part fades beside an edge


def passes_flow(edges: Edges, unit: Array | None, shape: tuple[int, int], radius: float, iterations: int) -> Array:
    """Return the ETF of edges and unit normals, (H, W, 2) float32; (1, 0) everywhere without any."""
    if unit is None:
        tangent, magnitude = np.zeros((*shape, 2), np.float32), np.zeros(shape, np.float32)
    else:
        tangent, magnitude = gradient.gradient(unit)
    largest = max(over_rows(_with_edges, shape[0], edges, tangent, magnitude))
    tangent = flow_fill(tangent, magnitude, _CERTAIN, largest)
    if iterations == 0 or radius <= 1:
        return tangent
    return smooth(tangent, magnitude, 1.0, iterations, footprint_passes("full", [radius], *shape))


@kernel
def _with_edges(first: int, last: int, edges: Edges, tangent: Array, magnitude: Array) -> float:
    """Lay edges over the tangents of the rows ``first`` .. ``last`` - 1; return the largest magnitude, at most 1."""
    height, width = magnitude.shape
    tensor = np.zeros((last - first, width, 3))
    for e in range(edges.rows[max(first - _REACH - 2, 0)], edges.rows[min(last + _REACH + 2, height)]):
        px, py, nx, ny = edges.x[e], edges.y[e], edges.nx[e], edges.ny[e]
        for y in range(max(first, math.ceil(py - _REACH)), min(last, math.floor(py + _REACH) + 1)):
            for x in range(max(0, math.ceil(px - _REACH)), min(width, math.floor(px + _REACH) + 1)):
                square = (x - px) * (x - px) + (y - py) * (y - py)
                w = _EDGE * edges.strength[e] ** 2 * math.exp(-0.5 * square) / (2 * math.pi)
                tensor[y - first, x, 0] += w * nx * nx
                tensor[y - first, x, 1] += w * nx * ny
                tensor[y - first, x, 2] += w * ny * ny
    largest = 0.0
    for y in range(first, last):
        for x in range(width):
            m = min(magnitude[y, x] / _STEEP, 1.0)
            xx, xy, yy = tensor[y - first, x, 0], tensor[y - first, x, 1], tensor[y - first, x, 2]
            if xx + yy > 0:
                of_normals = m * m * max(1 - _INSTEAD * (xx + yy), 0)
                tx, ty = tangent[y, x, 0], tangent[y, x, 1]
                xx, xy, yy = xx + of_normals * ty * ty, xy - of_normals * tx * ty, yy + of_normals * tx * tx
                m = min(math.sqrt((xx + yy + math.hypot(xx - yy, 2 * xy)) / 2), 1.0)
                angle = 0.5 * math.atan2(2 * xy, xx - yy)
                tangent[y, x, 0], tangent[y, x, 1] = -math.sin(angle), math.cos(angle)
            magnitude[y, x] = m
            largest = max(largest, m)
    return largest
