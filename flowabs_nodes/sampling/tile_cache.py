"""Copies of tiles of a picture, with the pixels around them, in a layout made for reading at scattered pixels.

Streamlines and gradient lines start from every pixel and reach a limited number of pixels. Kernels copy what a tile's
pixels can reach into a small array first, for two reasons. The copy stays in the processor's cache, where a picture
with its long rows does not. And the copy holds together what is read together, so that a single load brings it:

- a *lattice* holds a plane as pairs (value, increase to the row below). Two neighbouring pairs, one load of 128 bits,
  are enough to interpolate between four pixels (:func:`sample_lattice`).
- *records* hold two pairs for each pixel: its tangent, and the values of two planes.

Pairs are complex64. A tile holds the border of the picture repeated once, so that a pixel outside only has to be
clamped (:func:`tile_offset`). Planes are (C, H, W) and flows (H, W) complex64, t.x + i t.y, both flattened.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array, Complex64, Int32
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.border import repeat_left, repeat_right
from flowabs_nodes.simd.jit import inlined
from flowabs_nodes.simd.lanes import LANES, Floats, Ints, absolute, any_lane, maximum, minimum, splat_floats
from flowabs_nodes.simd.memory import gather_quads, load, load_pairs, store_pairs, store_quads

#: The size of a tile in pixels.
ROWS, COLUMNS = 64, 128
#: The longest x or y of a tangent that tiles allow. :func:`reach` counts on it.
LONGEST = 1.25


class PlanesShape(NamedTuple):
    """The shape (C, H, W) of planes that kernels get flattened."""

    channels: int
    height: int
    width: int


class Tile(NamedTuple):
    """The part of a picture that is copied.

    Its columns are left .. right + 1 and its rows top .. bottom + 1, of which the last column and row are only read to
    interpolate. ``left`` and ``top`` are -1 or more; ``right`` and ``bottom`` are the picture's last or less.
    """

    left: int
    top: int
    right: int
    bottom: int
    stride: int  # pixels from one row to the next in the copy
    width: int  # of the whole picture, in pixels
    height: int


def over_tiles(
    kernel: Callable[..., bool], planes: Array, flow: Array, weights: npt.NDArray[np.floating], *more: Any
) -> Array | None:
    """Return the result of a compiled ``kernel`` that works in tiles, or None if a tangent is longer than LONGEST.

    Parameters
    ----------
    kernel
        Is called as ``kernel(first, last, planes, shape, flow, weights, *more, result)`` for bands of rows. It writes
        the rows first .. last - 1 of ``result``, planes of the same shape, and returns whether all tangents were short
        enough.
    planes
        (C, H, W).
    flow
        (H, W, 2).
    weights
        The kernel's weights, passed to it as float32.
    more
        Whatever else the kernel takes.
    """
    width = planes.shape[2]
    planes, flow = pad_width(planes, 2), pad_width(flow, 1)
    result = np.empty_like(planes)
    pictures = planes.reshape(-1), PlanesShape(*planes.shape), flow.reshape(-1).view(np.complex64)
    weights = weights.astype(np.float32)
    fits = over_rows(kernel, planes.shape[1], *pictures, weights, *more, result.reshape(-1), least=ROWS)
    return np.ascontiguousarray(result[..., :width]) if all(fits) else None


def pad_width(planes: Array, axis: int) -> Array:
    """Return ``planes`` with at least sixteen columns (axis ``axis``), the last column repeated.

    Streamlines that leave the picture read there what they would read at its border.
    """
    missing = LANES - planes.shape[axis]
    if missing <= 0:
        return planes
    return np.pad(planes, [(0, missing if each == axis else 0) for each in range(planes.ndim)], "edge")


@inlined
def reach(steps: int) -> int:
    """Return how many pixels away a point can be after ``steps`` steps, with the pixels around it."""
    return steps + steps // 4 + 2


@inlined
def tile_capacity(steps: int, rows: int, width: int, height: int) -> Any:
    """Return how many pixels the largest copied tile of a band of ``rows`` rows of a picture has."""
    high = min(min(ROWS, rows) + 2 * reach(steps), height) + 3
    return high * (min(COLUMNS + 2 * reach(steps), width) + 3 * LANES)


@inlined
def tile_around(x: int, y: int, x_end: int, y_end: int, steps: int, width: int, height: int) -> Tile:
    """Return the part of a picture that ``steps`` steps can reach from columns x .. x_end - 1, rows y .. y_end - 1."""
    far = reach(steps)
    left, right = max(min(x, width - LANES) - far, -1), min(x_end + far, width - 1)
    return Tile(left, max(y - far, -1), right, min(y_end + far, height - 1), right - left + 2 + LANES, width, height)


@inlined
def tile_offset(x: Ints, y: Ints, tile: Tile) -> Ints:
    """Return the indices in the tile of the pixels in columns ``x`` and rows ``y``, clamped to the tile."""
    row, column = minimum(maximum(y, tile.top), tile.bottom), minimum(maximum(x, tile.left), tile.right)
    return (row * tile.stride + column) - (tile.top * tile.stride + tile.left)


@inlined
def sample_lattice(lattice: Complex64, places: Int32, k: int, u: Floats, v: Floats) -> Floats:
    """Return bilinear samples at the points ``u`` to the right of and ``v`` below the pixels places[k .. k + 15].

    ``places`` holds indices from :func:`tile_offset`; u and v are in pixels, 0 to 1.
    """
    here, change, right, right_change = gather_quads(lattice, places, k)
    here, right = here + v * change, right + v * right_change
    return here + u * (right - here)


@inlined
def fill_lattice(lattice: Complex64, plane: Array, start: int, tile: Tile) -> None:
    """Fill ``lattice`` with the part in the tile of the plane that begins at plane[start]."""
    for y in range(tile.top, tile.bottom + 2):
        row, below = start + _picture_row(y, tile), start + _picture_row(y + 1, tile)
        to = _tile_row(y, tile)
        for x0 in range(max(tile.left, 0), min(tile.right + 2, tile.width), LANES):
            x = min(x0, tile.width - LANES)
            here = load(plane, row + x)
            store_pairs(lattice, to + x, (here, load(plane, below + x) - here))
        _repeat_border(lattice, to, tile, 1)


@inlined
def count_busy(busy: Int32, plane: Array, ground: float, x0: int, x_end: int, far: int, tile: Tile) -> None:
    """Count the rows of the tile that are not all ``ground`` near each block of sixteen pixels from column x0 on.

    Near are the columns up to ``far`` away. ``busy`` is (rows + 1, blocks): its row i counts the first i of the tile.
    """
    for block in range((x_end - x0 + LANES - 1) // LANES):
        x = min(x0 + block * LANES, tile.width - LANES)
        busy[0, block] = 0
        for y in range(tile.top, tile.bottom + 2):
            most = splat_floats(0.0)
            for near in range(max(x - far, 0), min(x + LANES + far, tile.width), LANES):
                here = load(plane, _picture_row(y, tile) + min(near, tile.width - LANES))
                most = maximum(most, absolute(here - ground))
            busy[y - tile.top + 1, block] = busy[y - tile.top, block] + (1 if any_lane(most > 0.0) else 0)


@inlined
def fill_tangents(tangents: Complex64, flow: Complex64, tile: Tile) -> bool:
    """Fill ``tangents`` with the part of the flow in the tile, and return whether none is too long."""
    fits = True
    for y in range(tile.top, tile.bottom + 2):
        row, to = _picture_row(y, tile), _tile_row(y, tile)
        for x0 in range(max(tile.left, 0), min(tile.right + 2, tile.width), LANES):
            x = min(x0, tile.width - LANES)
            tx, ty = load_pairs(flow, row + x)
            fits = fits and is_short(tx, ty)
            store_pairs(tangents, to + x, (tx, ty))
        _repeat_border(tangents, to, tile, 1)
    return fits


@inlined
def fill_records(records: Complex64, flow: Complex64, planes: Array, starts: tuple[int, int], tile: Tile) -> bool:
    """Fill ``records`` with the flow and two planes, and return whether no tangent is too long.

    The planes begin at planes[starts[0]] and planes[starts[1]].
    """
    fits = True
    for y in range(tile.top, tile.bottom + 2):
        row, to = _picture_row(y, tile), 2 * _tile_row(y, tile)
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
def is_short(tx: Floats, ty: Floats) -> bool:
    """Return whether no component of sixteen tangents is longer than LONGEST."""
    return not any_lane(maximum(absolute(tx), absolute(ty)) > LONGEST)


@inlined
def _picture_row(y: int, tile: Tile) -> int:
    """Return the index in a plane at which row y, clamped to the picture, begins."""
    return min(max(y, 0), tile.height - 1) * tile.width


@inlined
def _tile_row(y: int, tile: Tile) -> int:
    """Return the index in the tile of column 0 of row y, whether or not the tile holds that column."""
    return (y - tile.top) * tile.stride - tile.left


@inlined
def _repeat_border(row: Complex64, to: int, tile: Tile, size: int) -> None:
    """Repeat the picture's first and last pixel of a row once, if the tile reaches beyond them.

    Column 0 of the row has the ``size`` items from row[to] on.
    """
    if tile.left < 0:
        repeat_left(row, to, 1, size)
    if tile.right == tile.width - 1:
        repeat_right(row, to + size * tile.width, 1, size)
