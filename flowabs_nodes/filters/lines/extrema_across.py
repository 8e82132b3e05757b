"""Grey-scale morphology along the gradient axis l_x: the largest and the smallest value of a picture across the flow.

Erosion, dilation, opening and closing with a line segment as structuring element (Serra, "Image Analysis and
Mathematical Morphology", 1982), which here lies across the flow at each pixel. Samples are bilinear.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters.lines.dog_line import locate_both_sides
from flowabs_nodes.filters.lines.edge_model import direction
from flowabs_nodes.sampling.tile_cache import (
    COLUMNS,
    ROWS,
    PlanesShape,
    fill_lattice,
    over_tiles,
    sample_lattice,
    tile_around,
    tile_capacity,
)
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.lanes import LANES, maximum
from flowabs_nodes.simd.memory import load, scratch, store

_POINTS = 8  # to either side are located before the first of them is sampled


def opening(plane: Array, flow: Array, length: float) -> Array:
    """Return the opening of a picture (H, W): what is brighter than its ground over less than ``length`` px is gone."""
    return largest(smallest(plane, flow, length), flow, length)


def closing(plane: Array, flow: Array, length: float) -> Array:
    """Return the closing of a picture (H, W): what is darker than its ground over less than ``length`` px is gone."""
    return smallest(largest(plane, flow, length), flow, length)


def smallest(plane: Array, flow: Array, length: float) -> Array:
    """Return the smallest value across the flow around each pixel, (H, W): the erosion."""
    return -largest(-plane, flow, length)


def largest(plane: Array, flow: Array, length: float) -> Array:
    """Return the largest value of a picture over a segment of each pixel's gradient axis, (H, W): the dilation.

    Parameters
    ----------
    plane
        (H, W) float32.
    flow
        (H, W, 2) float32 tangents, of which only the direction counts.
    length
        Length of the segment in pixels, above 0. Its middle is the pixel; it is sampled at equal steps of at most one.
    """
    half = length / 2
    points = math.ceil(half)
    result = over_tiles(_largest, plane[None], flow, half * np.arange(1, points + 1) / points)
    assert result is not None  # whatever the length of tangents
    largest_of_all: Array = result[0]
    return largest_of_all


@kernel
def _largest(
    first: int,
    last: int,
    planes: Array,
    shape: PlanesShape,
    flow: npt.NDArray[np.complex64],
    distances: Array,
    result: Array,
) -> bool:
    """Write the rows ``first`` .. ``last`` - 1 of a plane's largest values up to ``distances`` across; return True.

    ``planes`` and ``result`` are (1, H, W) float32, ``flow`` (H, W) complex64, all flattened.
    """
    _, height, width = shape
    points = distances.size
    steps = int(np.ceil(distances[points - 1]))
    entries, offsets = scratch(np.int32, 16), scratch(np.float32, 16)
    lattice = np.empty(tile_capacity(steps, last - first, width, height), np.complex64)
    for y0 in range(first, last, ROWS):
        for x0 in range(0, width, COLUMNS):
            y_end, x_end = min(y0 + ROWS, last), min(x0 + COLUMNS, width)
            around = tile_around(x0, y0, x_end, y_end, steps, width, height)
            fill_lattice(lattice, planes, 0, around)
            for y in range(y0, y_end):
                for each in range(x0, x_end, LANES):
                    x = min(each, width - LANES)
                    tx, ty = direction(flow, y * width + x)
                    most = load(planes, y * width + x)
                    for n0 in range(0, points, _POINTS):
                        n_end = min(n0 + _POINTS, points)
                        for n in range(n0, n_end):
                            far = distances[n]
                            locate_both_sides(ty * far, -tx * far, x, y, around, entries, offsets, n - n0)
                        for n in range(n0, n_end):
                            k = 2 * LANES * (n - n0)
                            u, v = load(offsets, k), load(offsets, k + LANES)
                            most = maximum(most, sample_lattice(lattice, entries, k, u, v))
                            most = maximum(most, sample_lattice(lattice, entries, k + LANES, 1.0 - u, 1.0 - v))
                    store(result, y * width + x, most)
    return True
