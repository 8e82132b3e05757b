"""Cracks: the borders between neighbouring pixels across which a surface ends, each with what is on its two sides.

**Depth.** Let u be affine on planes (``affine_depth.py``), and a, b, c, d four pixels in a row. Between b and c

    own = (2 u_b - u_a) - u_c,  far = u_b - (2 u_c - u_d),  raw = u_b - u_c

are how far c lies behind the plane of a and b, how far b lies before the plane of c and d, and how far apart they are.
Where the three have one sign, the step is J = sign min(|own|, |far|, |raw|) / max(|u_b|, |u_c|), else 0. At a jump
between planes, |J| = 1 - Z_near / Z_far; planes, however grazing, and creases give 0. J > 0: b is nearer.

**Ids.** A crack between two ids, or between two materials of one id, is there whatever the depth says. Depth cracks
beside an id's border are the same edge, a pixel off, and are left out.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array, Float64, Int64
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel

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
    id: Array  # uint32
    coverage: Array
    material: Array  # uint32


class Cracks(NamedTuple):
    """A table of cracks in order of their rows, and where each row of the picture begins."""

    table: Float64  # (N, COLUMNS)
    rows: Int64  # (H + 1,)


def in_rows(tables: list[Float64], height: int) -> Cracks:
    """Return the tables that bands of rows gave, as one."""
    table = np.concatenate(tables)
    return Cracks(table, np.searchsorted(np.floor(table[:, Y]), np.arange(height + 1)))


def find_cracks(passes: Passes, height: int, depth_step: float) -> Cracks:
    """Return every crack of the passes with a depth step from ``depth_step`` / 4 on, or between two ids or materials."""
    return in_rows(over_rows(_find, height, passes, depth_step), height)


@kernel
def _find(first: int, last: int, passes: Passes, depth_step: float) -> Float64:
    """Return the table of the cracks below, and to the right of, the pixels of the rows ``first`` .. ``last`` - 1."""
    height = max(passes.u.shape[0], passes.id.shape[0], passes.material.shape[0])
    width = max(passes.u.shape[1], passes.id.shape[1], passes.material.shape[1])
    table, count = np.empty((256, COLUMNS)), 0
    for y in range(first, last):
        for x in range(width):
            for along_x in range(2):  # in order of x
                x1, y1 = x + along_x, y + 1 - along_x
                if x1 >= width or y1 >= height:
                    continue
                known_by, step = _crack(passes, x, y, x1, y1, depth_step)
                if known_by < 0:
                    continue
                if count == table.shape[0]:
                    longer = np.empty((2 * count, COLUMNS))
                    longer[:count] = table
                    table = longer
                _note(passes, x, y, x1, y1, known_by, step, table[count])
                count += 1
    return table[:count].copy()


@inlined
def _crack(passes: Passes, x: int, y: int, x1: int, y1: int, depth_step: float) -> tuple[int, float]:
    """Return what a crack between two pixels is known by, -1 where there is none, and its step J by the depth."""
    known_by = -1
    if passes.id.size > 0 and passes.id[y, x] != passes.id[y1, x1]:
        known_by = ID
    elif passes.material.size > 0 and passes.material[y, x] != passes.material[y1, x1]:
        known_by = MATERIAL
    step = 0.0
    if passes.u.size > 0:
        u, v = np.float64(passes.u[y, x]), np.float64(passes.u[y1, x1])
        if known_by >= 0 or abs(u - v) > 0.25 * depth_step * max(abs(u), abs(v)):
            step = _step(passes, x, y, x1, y1)
            beyond = abs(step) > 0.25 * depth_step
            if known_by < 0 and beyond and not _beside_an_id(passes.id, x, y, x1, y1):
                known_by = DEPTH
    return known_by, step


@inlined
def _step(passes: Passes, x: int, y: int, x1: int, y1: int) -> float:
    """Return J between two neighbouring pixels; beyond the picture its border is repeated."""
    u, far = passes.u, passes.far
    height, width = u.shape
    xa, ya = max(2 * x - x1, 0), max(2 * y - y1, 0)
    xd, yd = min(2 * x1 - x, width - 1), min(2 * y1 - y, height - 1)
    a, b, c, d = np.float64(u[ya, xa]), np.float64(u[y, x]), np.float64(u[y1, x1]), np.float64(u[yd, xd])
    if b <= far and c <= far:
        return 0.0
    if (b <= far or c <= far) and max(b, c) >= passes.unknown:
        # All that is known of the background is that it lies beyond what the file's numbers can say.
        a, b = _at_most_so_far(a, passes), _at_most_so_far(b, passes)
        c, d = _at_most_so_far(c, passes), _at_most_so_far(d, passes)
    own, beyond, raw = (2 * b - a) - c, b - (2 * c - d), b - c
    if raw > 0 and own > 0 and beyond > 0:
        return min(own, beyond, raw) / max(abs(b), abs(c))
    if raw < 0 and own < 0 and beyond < 0:
        return max(own, beyond, raw) / max(abs(b), abs(c))
    return 0.0


@inlined
def _apart(u: Array, x: int, y: int, x1: int, y1: int) -> float:
    """Return how far the plane of the first two pixels lies before that of the last two, at the crack between."""
    height, width = u.shape
    xa, ya = max(2 * x - x1, 0), max(2 * y - y1, 0)
    xd, yd = min(2 * x1 - x, width - 1), min(2 * y1 - y, height - 1)
    first = 1.5 * u[y, x] - 0.5 * u[ya, xa]
    second = 1.5 * u[y1, x1] - 0.5 * u[yd, xd]
    return first - second


@inlined
def _at_most_so_far(u: float, passes: Passes) -> float:
    """Return ``passes.unknown`` for the u of the background, else u."""
    return passes.unknown if u <= passes.far else u


@inlined
def _beside_an_id(ids: Array, x: int, y: int, x1: int, y1: int) -> bool:
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
def _note(passes: Passes, x: int, y: int, x1: int, y1: int, known_by: int, step: float, crack: Float64) -> None:
    """Write what is known of a crack into its row of the table."""
    crack[X], crack[Y], crack[ALONG_X], crack[STEP], crack[KNOWN_BY] = (
        (x + x1) / 2,
        (y + y1) / 2,
        x1 - x,
        step,
        known_by,
    )
    crack[NEARER], crack[BEHIND], crack[FIRST_DEPTH], crack[SECOND_DEPTH] = 0, 0, 0, 0
    crack[FIRST], crack[SECOND], crack[SHIFT] = 0, 0, 0
    if passes.u.size > 0:
        u, v = np.float64(passes.u[y, x]), np.float64(passes.u[y1, x1])
        crack[FIRST_DEPTH], crack[SECOND_DEPTH] = u, v
        size = max(abs(u), abs(v))
        crack[NEARER] = min(max(_apart(passes.u, x, y, x1, y1) / (_TIE * size), -1), 1) if size > 0 else 0
        crack[BEHIND] = (1 if v <= passes.far else 0) - (1 if u <= passes.far else 0)
    if passes.id.size > 0:
        crack[FIRST], crack[SECOND] = passes.id[y, x], passes.id[y1, x1]
        if known_by == ID and (crack[FIRST] == 0 or crack[SECOND] == 0):
            crack[BEHIND] = 1 if crack[SECOND] == 0 else -1  # id 0 is the background
    if known_by == MATERIAL:
        crack[FIRST], crack[SECOND] = passes.material[y, x], passes.material[y1, x1]
    if known_by == ID and passes.coverage.size > 0:
        crack[SHIFT] = min(max(passes.coverage[y, x] - passes.coverage[y1, x1], -0.5), 0.5)
