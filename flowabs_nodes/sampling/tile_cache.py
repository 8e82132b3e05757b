"""Tiles of a picture with what lies around them, laid out anew for reading at scattered places.

Walks and gradient lines start from every pixel and go no further than so many pixels. What they read is copied into a
small piece of memory first, tile by tile, for two reasons. It stays in the cache, where pictures with their long rows
do not. And records can be put together there that one load brings whole, once for each place that is read:

- a *lattice* is a plane as pairs (value, how much more it is a row below): two neighbouring pairs, one load of 128
  bits, are all that is needed to read bilinearly between four pixels (:func:`sample_lattice`);
- *records* are a tangent and the values of two planes.

Around the picture its border is repeated once: a place needs no care but to be clamped (:func:`tile_offset`).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.border import repeat_left, repeat_right
from flowabs_nodes.simd.jit import inlined
from flowabs_nodes.simd.lanes import LANES, absolute, any_lane, maximum, minimum
from flowabs_nodes.simd.memory import gather_quads, load, load_pairs, store_pairs, store_quads

ROWS, COLUMNS = 64, 128
LONGEST = 1.25  # component of a tangent that is still about a unit vector


class PlanesShape(NamedTuple):
    """Of some planes, which kernels see in one dimension."""

    channels: int
    height: int
    width: int


class Tile(NamedTuple):
    """The part of a picture that is copied. It begins in column and row -1 at the earliest, and ends at the last."""

    left: int  # the first and last places that reading bilinearly starts from; a column and a row more are there
    top: int
    right: int
    bottom: int
    stride: int  # length of a row in memory
    width: int  # of the picture
    height: int


def over_tiles(kernel: Any, planes: Array, flow: Array, weights: npt.NDArray[np.floating]) -> Array | None:
    """What ``kernel`` makes of planes (C, H, W); None where a tangent is too long for it.

    It is called as kernel(first, last, planes, shape, flow, weights, result), with arrays of one dimension and the flow
    as complex numbers, and returns whether none was.
    """
    width = planes.shape[2]
    planes, flow = pad_width(planes, 2), pad_width(flow, 1)
    result = np.empty_like(planes)
    pictures = planes.reshape(-1), PlanesShape(*planes.shape), flow.reshape(-1).view(np.complex64)
    weights = weights.astype(np.float32)
    fits = over_rows(kernel, planes.shape[1], *pictures, weights, result.reshape(-1), least=ROWS)
    return np.ascontiguousarray(result[..., :width]) if all(fits) else None


def pad_width(planes: Array, axis: int) -> Array:
    """Planes at least 16 pixels wide, the border repeated: walks out there read what they would read at the border."""
    missing = LANES - planes.shape[axis]
    if missing <= 0:
        return planes
    return np.pad(planes, [(0, missing if each == axis else 0) for each in range(planes.ndim)], "edge")


@inlined
def reach(steps: Any) -> Any:
    """How many pixels away ``steps`` steps lead at most."""
    return steps + steps // 4 + 2


@inlined
def tile_capacity(steps: int, rows: int, width: int, height: int) -> Any:
    """How much memory the largest tile needs, of a band of so many rows of a picture."""
    high = min(min(ROWS, rows) + 2 * reach(steps), height) + 3
    return high * (min(COLUMNS + 2 * reach(steps), width) + 3 * LANES)


@inlined
def tile_around(x: int, y: int, x_end: int, y_end: int, steps: int, width: int, height: int) -> Tile:
    """What can be reached from the columns x .. x_end - 1 and rows y .. y_end - 1."""
    far = reach(steps)
    left, right = max(min(x, width - LANES) - far, -1), min(x_end + far, width - 1)
    return Tile(left, max(y - far, -1), right, min(y_end + far, height - 1), right - left + 2 + LANES, width, height)


@inlined
def tile_offset(x: Any, y: Any, tile: Tile) -> Any:
    """Where in the tile pixels are."""
    row, column = minimum(maximum(y, tile.top), tile.bottom), minimum(maximum(x, tile.left), tile.right)
    return (row * tile.stride + column) - (tile.top * tile.stride + tile.left)


@inlined
def sample_lattice(lattice: Any, places: Any, k: int, u: Any, v: Any) -> Any:
    """Read bilinearly u pixels to the right of places[k .. k + 15] and v below."""
    here, change, right, right_change = gather_quads(lattice, places, k)
    here, right = here + v * change, right + v * right_change
    return here + u * (right - here)


@inlined
def fill_lattice(lattice: Any, plane: Any, start: int, tile: Tile) -> None:
    """With the plane that begins at plane[start]."""
    for y in range(tile.top, tile.bottom + 2):
        row, below = start + _row(y, tile), start + _row(y + 1, tile)
        to = _first(y, tile)
        for x0 in range(max(tile.left, 0), min(tile.right + 2, tile.width), LANES):
            x = min(x0, tile.width - LANES)
            here = load(plane, row + x)
            store_pairs(lattice, to + x, (here, load(plane, below + x) - here))
        _repeat_border(lattice, to, tile, 1)


@inlined
def fill_tangents(tangents: Any, flow: Any, tile: Tile) -> bool:
    """With the flow; whether no tangent is too long."""
    fits = True
    for y in range(tile.top, tile.bottom + 2):
        row, to = _row(y, tile), _first(y, tile)
        for x0 in range(max(tile.left, 0), min(tile.right + 2, tile.width), LANES):
            x = min(x0, tile.width - LANES)
            tx, ty = load_pairs(flow, row + x)
            fits = fits and is_short(tx, ty)
            store_pairs(tangents, to + x, (tx, ty))
        _repeat_border(tangents, to, tile, 1)
    return fits


@inlined
def fill_records(records: Any, flow: Any, planes: Any, starts: tuple[int, int], tile: Tile) -> bool:
    """With the flow and the planes that begin at planes[starts]; whether no tangent is too long."""
    fits = True
    for y in range(tile.top, tile.bottom + 2):
        row, to = _row(y, tile), 2 * _first(y, tile)
        for x0 in range(max(tile.left, 0), min(tile.right + 2, tile.width), LANES):
            x = min(x0, tile.width - LANES)
            tx, ty = load_pairs(flow, row + x)
            fits = fits and is_short(tx, ty)
            store_quads(
                records, to + 2 * x, (tx, ty, load(planes, starts[0] + row + x), load(planes, starts[1] + row + x))
            )
        _repeat_border(records, to, tile, 2)
    return fits


@inlined
def is_short(tx: Any, ty: Any) -> bool:
    return not any_lane(maximum(absolute(tx), absolute(ty)) > LONGEST)


@inlined
def _row(y: int, tile: Tile) -> int:
    """Where a row of the picture begins."""
    return min(max(y, 0), tile.height - 1) * tile.width


@inlined
def _first(y: int, tile: Tile) -> int:
    """Where column 0 of a row would be in the tile."""
    return (y - tile.top) * tile.stride - tile.left


@inlined
def _repeat_border(row: Any, to: int, tile: Tile, size: int) -> None:
    """Repeat the border once where the tile reaches over it; records of ``size`` items, that of column 0 at row[to]."""
    if tile.left < 0:
        repeat_left(row, to, 1, size)
    if tile.right == tile.width - 1:
        repeat_right(row, to + size * tile.width, 1, size)
