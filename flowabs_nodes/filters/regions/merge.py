"""Region merging: connected regions of like colour get one colour each, after small ones merged with a neighbour.

Regions are the trees of a disjoint-set forest over the pixels, numbered y W + x: ``parent[i]`` leads from pixel i
towards the root of its tree. The root is the region's first pixel in reading order, so that the order in which regions
merge does not matter. ``size`` (pixels) and ``total`` (sums of colours, (H W, 3) float64) are kept at the roots.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array, Float64, Int64
from flowabs_nodes.simd.bands import limited, over_rows
from flowabs_nodes.simd.jit import inlined, kernel

Covered = npt.NDArray[np.bool_]


def flatten_regions(image: Array, covered: Covered, limit: float, min_region: int) -> None:
    """Give every region the mean of its colours, in place, after merging regions of fewer than ``min_region`` pixels.

    Neighbouring pixels (4-connected) belong to one region where their colours differ by at most ``limit``. In rounds,
    each region that is too small merges with the neighbour whose mean colour is nearest (of equals, the one found
    first, row by row), until no region is too small or the small ones have no neighbour left.

    Parameters
    ----------
    image
        Colours, (H, W, 3) float32, changed in place.
    covered
        (H, W); pixels that are not covered belong to no region and keep their colour.
    limit
        Largest Euclidean distance of colours within a region from pixel to pixel, in the image's units.
    min_region
        Fewest pixels of a region.
    """
    height, width, _ = image.shape
    count = height * width
    parent = np.arange(count)
    size, total = np.zeros(count, np.int64), np.zeros((count, 3))
    # Of each small region's root: the root of its nearest neighbour, and their squared distance in colour.
    nearest, distance = np.empty(count, np.int64), np.empty(count)
    with limited(1):  # each region depends on those before it: row by row, where it may be asked to stop
        over_rows(_join_alike, height, image, covered, float(limit), parent)
        over_rows(_add_up, height, image, parent, size, total)
        merged = True
        while merged:
            nearest[:], distance[:] = -1, np.inf
            over_rows(_find_nearest, height, covered, parent, size, total, min_region, nearest, distance)
            merged = any(over_rows(_join_nearest, height, width, parent, size, total, nearest))
        over_rows(_paint, height, image, covered, parent, size, total)


@kernel
def _join_alike(first: int, last: int, image: Array, covered: Covered, limit: float, parent: Int64) -> None:
    """Join each covered pixel of the rows ``first`` .. ``last`` - 1 with the next ones right and below, if alike."""
    height, width, _ = image.shape
    for y in range(first, last):
        for x in range(width):
            i = y * width + x
            if x + 1 < width and covered[y, x] and covered[y, x + 1] and _alike(image[y, x], image[y, x + 1], limit):
                _union(parent, i, i + 1)
            if y + 1 < height and covered[y, x] and covered[y + 1, x] and _alike(image[y, x], image[y + 1, x], limit):
                _union(parent, i, i + width)


@kernel
def _add_up(first: int, last: int, image: Array, parent: Int64, size: Int64, total: Float64) -> None:
    """Add the pixels of the rows ``first`` .. ``last`` - 1 to the size and the colour of their regions."""
    width = image.shape[1]
    for i in range(first * width, last * width):
        _add(parent, i, image[i // width, i % width], size, total)


@kernel
def _find_nearest(
    first: int,
    last: int,
    covered: Covered,
    parent: Int64,
    size: Int64,
    total: Float64,
    min_region: int,
    nearest: Int64,
    distance: Float64,
) -> None:
    """Compare each region with its neighbours in the rows ``first`` .. ``last`` - 1, and below the last."""
    height, width = covered.shape
    for y in range(first, last):
        for x in range(width):
            i = y * width + x
            if x + 1 < width and covered[y, x] and covered[y, x + 1]:
                _compare(_root(parent, i), _root(parent, i + 1), size, total, min_region, nearest, distance)
            if y + 1 < height and covered[y, x] and covered[y + 1, x]:
                _compare(_root(parent, i), _root(parent, i + width), size, total, min_region, nearest, distance)


@kernel
def _join_nearest(
    first: int, last: int, width: int, parent: Int64, size: Int64, total: Float64, nearest: Int64
) -> bool:
    """Join small regions whose root is in the rows ``first`` .. ``last`` - 1 with their nearest; whether any was."""
    merged = False
    for i in range(first * width, last * width):
        if nearest[i] >= 0:
            a, b = _root(parent, i), _root(parent, nearest[i])
            if a != b:
                _union(parent, a, b)
                kept, gone = min(a, b), max(a, b)
                size[kept] += size[gone]
                for c in range(3):
                    total[kept, c] += total[gone, c]
                merged = True
    return merged


@kernel
def _paint(first: int, last: int, image: Array, covered: Covered, parent: Int64, size: Int64, total: Float64) -> None:
    """Give each covered pixel of the rows ``first`` .. ``last`` - 1 the mean colour of its region."""
    width = image.shape[1]
    for y in range(first, last):
        for x in range(width):
            root = _root(parent, y * width + x)
            for c in range(3):
                if covered[y, x]:
                    image[y, x, c] = np.float32(total[root, c] / size[root])


@inlined
def _alike(one: Array, other: Array, limit: float) -> bool:
    """Return whether two colours (3,) differ by at most ``limit``."""
    square = 0.0
    for c in range(3):
        square += (np.float64(one[c]) - other[c]) ** 2
    return square <= limit * limit


@inlined
def _root(parent: Int64, i: int) -> int:
    """Return the root of pixel i, and shorten the way to it (path halving)."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@inlined
def _union(parent: Int64, i: int, j: int) -> None:
    """Merge the regions of the pixels i and j; the smaller root stays a root."""
    i, j = _root(parent, i), _root(parent, j)
    parent[max(i, j)] = min(i, j)


@inlined
def _add(parent: Int64, i: int, colour: Array, size: Int64, total: Float64) -> None:
    """Count pixel i and its colour in its region."""
    root = _root(parent, i)
    size[root] += 1
    for c in range(3):
        total[root, c] += colour[c]


@inlined
def _compare(a: int, b: int, size: Int64, total: Float64, min_region: int, nearest: Int64, distance: Float64) -> None:
    """Note for two regions that touch, with roots a and b, that each may be the nearest neighbour of the other.

    Only small regions have their nearest neighbour noted.
    """
    if a == b or (size[a] >= min_region and size[b] >= min_region):
        return
    square = 0.0
    for c in range(3):
        square += (total[a, c] / size[a] - total[b, c] / size[b]) ** 2
    if size[a] < min_region and square < distance[a]:
        nearest[a], distance[a] = b, square
    if size[b] < min_region and square < distance[b]:
        nearest[b], distance[b] = a, square
