"""Cracks: the borders between neighbouring pixels across which a surface ends, each with what is on its two sides.

There is a crack where depth makes a step (``depth_steps.py``), and between two ids, or two materials of one id,
whatever the depth says. Depth cracks beside an id's border are the same edge, a pixel off, and are left out.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array, Float64, Int32, Int64, Uint32
from flowabs_nodes.filters.passes.depth_steps import apart, may_step, relative_step
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, Masks, lane_indices, set_lanes
from flowabs_nodes.simd.memory import address, load

#: What a crack is known by.
DEPTH, ID, MATERIAL = 0, 1, 2

#: The columns of a table of cracks. The *first* pixel is the left or the upper one; numbers of a direction are
#: positive where it is the nearer one.
(
    X,  # where the crack is: its middle
    Y,
    ALONG_X,  # 1 where the second pixel is to the right, 0 where it is below
    STEP,  # J
    NEARER,  # -1 to 1: the relative step, whatever the planes
    BEHIND,  # 1 where the second is background, -1 where the first is
    FIRST,  # ids, or materials
    SECOND,
    FIRST_DEPTH,  # u
    SECOND_DEPTH,
    SHIFT,  # where in the direction of the second pixel the edge itself lies, by the coverage
    KNOWN_BY,
) = range(12)
COLUMNS = 12

_TIE = 0.005  # relative step at which it is certain which side is nearer


class Passes(NamedTuple):
    """The passes of a picture, (H, W) each; of size 0 where there is none."""

    u: Array
    far: float
    unknown: float
    id: Uint32
    coverage: Array
    material: Uint32


class Cracks(NamedTuple):
    """A table of cracks in order of their rows, and where each row of the picture begins."""

    table: Float64  # (N, COLUMNS)
    rows: Int64  # (H + 1,)


def in_rows(tables: list[Float64], height: int) -> Cracks:
    """Return the tables that bands of rows gave, as one."""
    table = np.concatenate(tables)
    return Cracks(table, np.searchsorted(np.floor(table[:, Y]), np.arange(height + 1)))


def find_cracks(passes: Passes, height: int, depth_step: float) -> Cracks:
    """Return every crack with a depth step from ``depth_step`` / 4 on, or between two ids or materials."""
    return in_rows(over_rows(_find, height, passes, _flat(passes), depth_step), height)


class _Flat(NamedTuple):
    """Passes as vectors are read of them."""

    u: Array
    id: Int32
    material: Int32


def _flat(passes: Passes) -> _Flat:
    return _Flat(passes.u.reshape(-1), passes.id.reshape(-1).view(np.int32), passes.material.reshape(-1).view(np.int32))


@kernel
def _find(first: int, last: int, passes: Passes, flat: _Flat, depth_step: float) -> Float64:
    """Return the table of the cracks below, and to the right of, the pixels of the rows ``first`` .. ``last`` - 1."""
    # Inlined functions below take no tuples of arrays: numba would count references to the arrays at every call.
    u, far, unknown, ids, coverage, materials = passes
    flat_u, flat_ids, flat_materials = address(flat.u, 0), address(flat.id, 0), address(flat.material, 0)
    has_u, has_ids, has_materials = u.size > 0, ids.size > 0, materials.size > 0
    height = max(u.shape[0], ids.shape[0], materials.shape[0])
    width = max(u.shape[1], ids.shape[1], materials.shape[1])
    limit = 0.25 * depth_step
    table, count = np.empty((256, COLUMNS)), 0
    for y in range(first, last):
        x = 0
        while x < width:
            # Sixteen pixels at a time where four in a row are inside the picture, else pixel by pixel. Each bit of
            # ``below`` and ``right`` is a pixel that may have a crack there.
            inside = x >= 1 and x + LANES + 1 < width and y >= 1 and y + 2 < height
            end = x + LANES if inside else x + 1
            below, right = 1, 1
            if inside:
                pixel = y * width + x
                cracked = torn = lane_indices() < 0
                if has_u:
                    cracked = may_step(flat_u, pixel, width, 0.99 * limit)
                    torn = may_step(flat_u, pixel, 1, 0.99 * limit)
                if has_ids:
                    cracked = cracked | _differ(flat_ids, pixel, width)
                    torn = torn | _differ(flat_ids, pixel, 1)
                if has_materials:
                    cracked = cracked | _differ(flat_materials, pixel, width)
                    torn = torn | _differ(flat_materials, pixel, 1)
                below, right = set_lanes(cracked), set_lanes(torn)
            while below | right:
                for along_x in range(2):  # in order of x
                    if not (right if along_x else below) & 1:
                        continue
                    x1, y1 = x + along_x, y + 1 - along_x
                    if x1 >= width or y1 >= height:
                        continue
                    known_by = _known_by(ids, materials, x, y, x1, y1)
                    step = relative_step(u, far, unknown, x, y, x1, y1) if u.size > 0 else 0.0
                    if known_by < 0 and (abs(step) <= limit or _beside_an_id(ids, x, y, x1, y1)):
                        continue
                    if count == table.shape[0]:
                        table = longer(table)
                    crack = table[count]
                    crack[X], crack[Y], crack[ALONG_X] = (x + x1) / 2, (y + y1) / 2, along_x
                    crack[STEP], crack[KNOWN_BY] = step, max(known_by, DEPTH)
                    _note(u, far, ids, coverage, materials, x, y, x1, y1, crack)
                    count += 1
                below, right, x = below >> 1, right >> 1, x + 1
            x = end
    return table[:count].copy()


@inlined
def _differ(ids: Int32, pixel: int, forward: int) -> Masks:
    """Return where sixteen ids are others than those ``forward`` of them."""
    change = load(ids, pixel) ^ load(ids, pixel + forward)
    return (change > 0) | (change < 0)


@inlined
def _known_by(ids: Uint32, materials: Uint32, x: int, y: int, x1: int, y1: int) -> int:
    """Return ID or MATERIAL where two pixels have not the same, -1 where they have."""
    if ids.size > 0 and ids[y, x] != ids[y1, x1]:
        return ID
    if materials.size > 0 and materials[y, x] != materials[y1, x1]:
        return MATERIAL
    return -1


@inlined
def longer(table: Float64) -> Float64:
    """Return a copy of a table that is full, with room for as many rows again."""
    grown = np.empty((2 * table.shape[0], table.shape[1]))
    grown[: table.shape[0]] = table
    return grown


@inlined
def _beside_an_id(ids: Uint32, x: int, y: int, x1: int, y1: int) -> bool:
    """Return whether a pixel of another id lies beside one of two neighbouring pixels of one id."""
    if ids.size == 0:
        return False
    own = ids[y, x]
    for j in range(max(y - 1, 0), min(y1 + 2, ids.shape[0])):
        for i in range(max(x - 1, 0), min(x1 + 2, ids.shape[1])):
            if ids[j, i] != own:
                return True
    return False


@inlined
def _note(
    u: Array,
    far: float,
    ids: Uint32,
    coverage: Array,
    materials: Uint32,
    x: int,
    y: int,
    x1: int,
    y1: int,
    crack: Float64,
) -> None:
    """Write what is on the two sides of a crack into its row of the table."""
    crack[NEARER], crack[BEHIND], crack[FIRST_DEPTH], crack[SECOND_DEPTH] = 0, 0, 0, 0
    crack[FIRST], crack[SECOND], crack[SHIFT] = 0, 0, 0
    known_by = crack[KNOWN_BY]
    if u.size > 0:
        b, c = np.float64(u[y, x]), np.float64(u[y1, x1])
        crack[FIRST_DEPTH], crack[SECOND_DEPTH] = b, c
        size = max(abs(b), abs(c))
        crack[NEARER] = min(max(apart(u, x, y, x1, y1) / (_TIE * size), -1), 1) if size > 0 else 0
        crack[BEHIND] = (1 if c <= far else 0) - (1 if b <= far else 0)
    if ids.size > 0:
        crack[FIRST], crack[SECOND] = ids[y, x], ids[y1, x1]
        if known_by == ID and (crack[FIRST] == 0 or crack[SECOND] == 0):
            crack[BEHIND] = 1 if crack[SECOND] == 0 else -1  # id 0 is the background
    if known_by == MATERIAL:
        crack[FIRST], crack[SECOND] = materials[y, x], materials[y1, x1]
    if known_by == ID and coverage.size > 0:
        crack[SHIFT] = min(max(coverage[y, x] - coverage[y1, x1], -0.5), 0.5)
