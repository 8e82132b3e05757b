"""Connected regions of like colour: small ones join their neighbours, and each gets one colour."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.simd.jit import inlined, kernel


def flatten_regions(image: Array, there: npt.NDArray[np.bool_], limit: float, min_region: int) -> None:
    """Give every region the mean of its colours, those of fewer than ``min_region`` pixels joined before; in place.

    Pixels that are ``there`` and touch at a side are of one region where their colours differ by at most ``limit``
    (Euclidean). In rounds, each region that is too small joins the neighbour whose mean colour is nearest (of equals,
    the one found first, row by row), until none is too small or has no neighbour left.
    """
    _flatten(image, there, float(limit), min_region)


@kernel
def _flatten(image: Any, there: Any, limit: float, min_region: int) -> None:
    height, width, _ = image.shape
    count = height * width
    parent = np.arange(count)  # of a forest, in which each tree is a region and its root names it
    for y in range(height):
        for x in range(width):
            i = y * width + x
            if x + 1 < width and there[y, x] and there[y, x + 1] and _alike(image[y, x], image[y, x + 1], limit):
                _unite(parent, i, i + 1)
            if y + 1 < height and there[y, x] and there[y + 1, x] and _alike(image[y, x], image[y + 1, x], limit):
                _unite(parent, i, i + width)

    size, total = np.zeros(count, np.int64), np.zeros((count, 3))
    for i in range(count):
        _add(parent, i, image[i // width, i % width], size, total)

    nearest, distance = np.empty(count, np.int64), np.empty(count)
    joined = True
    while joined:
        nearest[:], distance[:] = -1, np.inf
        for y in range(height):
            for x in range(width):
                i = y * width + x
                if x + 1 < width and there[y, x] and there[y, x + 1]:
                    _meet(_root(parent, i), _root(parent, i + 1), size, total, min_region, nearest, distance)
                if y + 1 < height and there[y, x] and there[y + 1, x]:
                    _meet(_root(parent, i), _root(parent, i + width), size, total, min_region, nearest, distance)
        joined = False
        for i in range(count):
            if nearest[i] >= 0:
                a, b = _root(parent, i), _root(parent, nearest[i])
                if a != b:
                    _unite(parent, a, b)
                    kept, gone = min(a, b), max(a, b)
                    size[kept] += size[gone]
                    for c in range(3):
                        total[kept, c] += total[gone, c]
                    joined = True

    for y in range(height):
        for x in range(width):
            root = _root(parent, y * width + x)
            for c in range(3):
                if there[y, x]:
                    image[y, x, c] = np.float32(total[root, c] / size[root])


@inlined
def _alike(one: Any, other: Any, limit: float) -> bool:
    square = 0.0
    for c in range(3):
        square += (np.float64(one[c]) - other[c]) ** 2
    return square <= limit * limit


@inlined
def _root(parent: Any, i: int) -> int:
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@inlined
def _unite(parent: Any, i: int, j: int) -> None:
    """The root is the first pixel of a region, so that it does not matter what was united first."""
    i, j = _root(parent, i), _root(parent, j)
    parent[max(i, j)] = min(i, j)


@inlined
def _add(parent: Any, i: int, colour: Any, size: Any, total: Any) -> None:
    root = _root(parent, i)
    size[root] += 1
    for c in range(3):
        total[root, c] += colour[c]


@inlined
def _meet(a: int, b: int, size: Any, total: Any, min_region: int, nearest: Any, distance: Any) -> None:
    """Two regions touch: each may be what the other, if it is small, has nearest."""
    if a == b or (size[a] >= min_region and size[b] >= min_region):
        return
    square = 0.0
    for c in range(3):
        square += (total[a, c] / size[a] - total[b, c] / size[b]) ** 2
    if size[a] < min_region and square < distance[a]:
        nearest[a], distance[a] = b, square
    if size[b] < min_region and square < distance[b]:
        nearest[b], distance[b] = a, square
