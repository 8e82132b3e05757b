"""A smooth field of vectors by chance, made for a place and a moment: no state, the same on every machine.

At the points of a square lattice stand unit vectors, by a hash of the point, the field's number and a seed. Between
them each part of the vector runs from point to point by Perlin's quintic, 6 t^5 - 15 t^4 + 10 t^3, along y and then
along x: two derivatives are continuous, and no vector is longer than 1. The lattice of each field is shifted by chance,
so that its points, where vectors are longest, lie elsewhere from field to field.

The places and the vectors are made of sums, products, quotients and roots of float64, which are exact by IEEE 754.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array, Float64, Int32

Uint32 = npt.NDArray[np.uint32]

_OCTANT = 2**0.5 - 1  # the tangent of 22.5 degrees
_HALF_ROOT = 0.5**0.5


class Field(NamedTuple):
    """A field of vectors over a picture: the pixels of column c lie between the points ``columns[c]`` and the next."""

    vectors: Array  # (2, rows, columns) of the lattice: x, then y
    columns: Int32  # (W,)
    across: Array  # (W,): the quintic of the way to the next column
    rows: Int32  # (H,)
    down: Array  # (H,)


def smooth_noise(shape: tuple[int, int], origin: tuple[int, int], size: float, seed: int, number: int) -> Field:
    """Return the field with this ``number``.

    Parameters
    ----------
    shape
        H and W, in pixels.
    origin
        Where the first pixel lies, x and y: the field belongs to places, whichever part of them is asked for.
    size
        Distance of the lattice's points in pixels.
    """
    of_seed = _hash(np.zeros(1), np.array([seed]))
    here = _hash(_hash(of_seed, np.array([number])), np.arange(2))
    shift = here / 2**32  # 0 to 1
    columns, across = _places(shape[1], origin[0], size, shift[0])
    rows, down = _places(shape[0], origin[1], size, shift[1])
    points = _hash(_hash(here[:1], np.arange(rows[0], rows[-1] + 2))[:, None], np.arange(columns[0], columns[-1] + 2))
    columns, rows = columns - columns[0], rows - rows[0]
    return Field(_unit_vectors(points), columns.astype(np.int32), across, rows.astype(np.int32), down)


def _places(count: int, first: int, size: float, shift: np.float64) -> tuple[npt.NDArray[np.int64], Array]:
    """Return the point of the lattice before each of the pixels from ``first`` on, and the quintic of the rest."""
    place = (first + np.arange(count)) / size + shift
    before = np.floor(place)
    t = place - before
    return before.astype(np.int64), (t * t * t * (t * (6 * t - 15) + 10)).astype(np.float32)


def _unit_vectors(chance: Uint32) -> Array:
    """Return vectors of length 1 in all directions, (2, ...): near the x axis, then turned by 45 degrees or more."""
    t = _OCTANT * (2 * ((chance >> 3) / 2**29) - 1)
    length = np.where(chance & 1, 1, -1) * np.sqrt(1 + t * t)
    x, y = 1 / length, t / length
    x, y = np.where(chance & 2, y, x), np.where(chance & 2, x, y)
    x, y = np.where(chance & 4, _HALF_ROOT * (x - y), x), np.where(chance & 4, _HALF_ROOT * (x + y), y)
    vectors: Float64 = np.stack([x, y])
    return vectors.astype(np.float32)


def _hash(h: npt.NDArray[Any], key: npt.NDArray[Any]) -> Uint32:
    """Return 32 bits of chance for each ``h`` and whole number ``key``: the last steps of MurmurHash3."""
    k = (h.astype(np.uint32) + np.uint32(0x9E3779B9)) ^ (key & 0xFFFFFFFF).astype(np.uint32)
    k = (k ^ k >> np.uint32(16)) * np.uint32(0x85EBCA6B)
    k = (k ^ k >> np.uint32(13)) * np.uint32(0xC2B2AE35)
    return k ^ k >> np.uint32(16)
