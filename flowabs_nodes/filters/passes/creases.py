"""Creases: points where normals turn more than they do beside them.

Along a row, and along a column, A(k) is the angle between the normals at k - h and k + h, h the reach, for k
in the middle between two pixels. A bend turns them over its length, and beside a crease they turn little: with

    excess = A(k) - (A(k - 2h) + A(k + 2h)) / 2,    sudden = min(A(k), 2 A(k) - A(k - s) - A(k + s)), s = max(h, 1),

which are both the whole angle of a sharp fold alone, the strength is smoothstep(theta / 2, theta, sudden)
smoothstep(.4 theta, .8 theta, excess). A crease goes through the peaks of A, found between pixels by a parabola.
Its direction is the major eigenvector of the sum of g g^T, g the gradient of a component of the normal.
"""

from __future__ import annotations

import math

import numpy as np

from flowabs_nodes.array_types import Array, Float64
from flowabs_nodes.filters.passes.cracks import longer
from flowabs_nodes.filters.passes.edges import CREASE, Edges, smoothstep
from flowabs_nodes.filters.passes.near import MOVED, begin_at, begin_rows
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, Floats, any_lane, select, set_lanes, sqrt
from flowabs_nodes.simd.memory import address, keep, load, load_triples, store, store_triples
from flowabs_nodes.simd.pixelwise import as_picture, as_run, empty_run, first_pixel, over_pixels

_COLUMNS = 6  # x, y, nx, ny, strength, excess
_ACROSS = 0.4  # the cosine between row, or column, and the crease's normal below which it runs along the crease
_ALONGSIDE = 2.5  # px: what is no further away goes along it
_ROWS = 6  # up and down from a crease's row, in which that is looked for
_SHARPER = 1.3  # times as much excess
_NO_NORMAL = 0.01  # squared length, of two normals' product, below which there is no angle between them
_SLACK = 1e-4  # of cosines that are compared in a hurry
_PARALLEL = 0.7  # the cosine from which directions are parallel


def unit_normals(normal: Array) -> Array:
    """Return normals (H, W, 3) at length 1; 0, 0, 0 where they are not finite, or shorter than a half."""
    pixels, unit = normal.shape[0] * normal.shape[1], empty_run(normal.size // 3, 3)
    over_pixels(_normalise, pixels, as_run(normal, 3), unit)
    return as_picture(unit, *normal.shape)


@kernel
def _normalise(first: int, last: int, normal: Array, unit: Array) -> None:
    """Write the unit normals of the blocks ``first`` .. ``last`` - 1 of sixteen pixels."""
    pixels = normal.size // 3
    for block in range(first, last):
        i = 3 * first_pixel(block, pixels)
        a, b, c = load_triples(normal, i)
        square = a * a + b * b + c * c
        there = (square >= 0.25) & (square < 1e30)
        inverse = 1.0 / sqrt(select(there, square, 1.0))
        store_triples(
            unit,
            i,
            (select(there, a * inverse, 0.0), select(there, b * inverse, 0.0), select(there, c * inverse, 0.0)),
        )


def find_creases(unit: Array, crease_angle: float, crease_reach: float) -> tuple[Edges, Float64]:
    """Return the creases of unit normals, (H, W, 3), and the excess of each in degrees."""
    height = unit.shape[0]
    table = np.concatenate(over_rows(_find, height, unit, unit.reshape(-1), crease_angle, crease_reach))
    rows = np.searchsorted(np.floor(table[:, 1]), np.arange(height + 1))
    zeros = np.zeros(len(table))
    x, y, nx, ny, strength, excess = (np.ascontiguousarray(column) for column in table.T)
    return Edges(rows, x, y, nx, ny, strength, zeros, zeros, zeros, np.full(len(table), CREASE, np.int32)), excess


@kernel
def _find(first: int, last: int, unit: Array, flat: Array, theta: float, h: float) -> Float64:
    """Return the table of the creases between the pixels of the rows ``first`` .. ``last`` - 1 and the next."""
    height, width = unit.shape[:2]
    table, count = np.empty((64, _COLUMNS)), 0
    found = np.empty(5)
    cosine = math.cos(math.radians(0.49 * theta))  # where normals turn less there is no strength
    reach = math.ceil(h) + 2
    top, bottom = max(first - reach, 0), min(last + reach, height)
    planes = _apart(flat, top * width, bottom * width)
    a, b, c = address(planes[0], 0), address(planes[1], 0), address(planes[2], 0)
    for y in range(first, last):
        x = 0
        while x < width:
            # Each bit of ``below`` and ``right`` is a pixel that may have a crease there.
            inside = reach <= x and x + LANES + reach < width and reach <= y and y + reach < height
            end = x + LANES if inside else x + 1
            below, right = 1, 1
            if inside:
                pixel = (y - top) * width + x
                below = _may_peak(a, b, c, pixel, width, h, cosine)
                right = _may_peak(a, b, c, pixel, 1, h, cosine)
            while below | right:
                for along_x in range(2):  # in order of x
                    if not (right if along_x else below) & 1:
                        continue
                    if (x if along_x else y) + 1 >= (width if along_x else height):
                        continue
                    if not _peak(unit, x, y, along_x, h, theta, found):
                        continue
                    if count == table.shape[0]:
                        table = longer(table)
                    table[count, 0] = x + along_x * (0.5 + found[1])
                    table[count, 1] = y + (1 - along_x) * (0.5 + found[1])
                    table[count, 2], table[count, 3] = found[2], found[3]
                    table[count, 4], table[count, 5] = found[0], found[4]
                    count += 1
                below, right, x = below >> 1, right >> 1, x + 1
            x = end
    keep(planes)
    return table[:count].copy()


@inlined
def _apart(flat: Array, first: int, last: int) -> Array:
    """Return normals of the pixels ``first`` .. ``last`` - 1 as a plane for each component; of few pixels nothing."""
    planes = np.empty((3, last - first), np.float32)
    if last - first >= LANES:
        for i in range(first, last, LANES):
            pixel = min(i, last - LANES)
            for k, component in enumerate(load_triples(flat, 3 * pixel)):
                store(planes[k], pixel - first, component)
    return planes


@inlined
def _may_peak(a: Array, b: Array, c: Array, pixel: int, forward: int, h: float, cosine: float) -> int:
    """Return for which of sixteen pixels A may have a peak before the next one of an angle with that ``cosine``.

    (a, b, c) are the components of normals, in memory. No peak is left out: of what is near one :func:`_peak` decides.
    """
    middle = _cosine(a, b, c, pixel, forward, 0.5, h, 0.5 * _NO_NORMAL)
    turned = middle < cosine
    if any_lane(turned):
        before = _cosine(a, b, c, pixel, forward, -0.5, h, 2 * _NO_NORMAL)
        after = _cosine(a, b, c, pixel, forward, 1.5, h, 2 * _NO_NORMAL)
        turned = turned & (before > middle - _SLACK) & (after > middle - _SLACK)
    found: int = set_lanes(turned)
    return found


@inlined
def _cosine(a: Array, b: Array, c: Array, pixel: int, forward: int, along: float, h: float, least: float) -> Floats:
    """Return the cosines between normals h before and h after ``along``; 1 where there are none.

    There are none where the product of their squared lengths is not above ``least``.
    """
    p, u = _between(a, pixel, forward, along - h), _between(a, pixel, forward, along + h)
    q, v = _between(b, pixel, forward, along - h), _between(b, pixel, forward, along + h)
    r, w = _between(c, pixel, forward, along - h), _between(c, pixel, forward, along + h)
    size = (p * p + q * q + r * r) * (u * u + v * v + w * w)
    there = size > least
    return select(there, (p * u + q * v + r * w) / sqrt(select(there, size, 1.0)), 1.0)


@inlined
def _between(plane: Array, pixel: int, forward: int, along: float) -> Floats:
    """Return what is ``along`` steps of ``forward`` from sixteen pixels, between pixels a mean of two."""
    i = math.floor(along)
    t = np.float32(along - i)
    here, there = load(plane, pixel + i * forward), load(plane, pixel + (i + 1) * forward)
    return here + t * (there - here)


def alone(creases: Edges, excess: Float64, edges: Edges) -> Edges:
    """Return creases without those that go along an edge, where normals turn too, or along a sharper crease."""
    strength = creases.strength.copy()
    over_rows(_fade, len(creases.rows) - 1, creases, excess, edges, strength)
    return creases._replace(strength=strength)


@kernel
def _fade(first: int, last: int, creases: Edges, excess: Float64, edges: Edges, strength: Float64) -> None:
    """Fade what goes along something of the creases in the rows ``first`` .. ``last`` - 1."""
    height, reach = edges.rows.size - 1, _ALONGSIDE + MOVED
    begins, crease_begins = np.empty(2 * _ROWS + 1, np.int64), np.empty(2 * _ROWS + 1, np.int64)
    for row in range(first, last):
        top = begin_rows(edges.rows, row, _ROWS, begins)
        begin_rows(creases.rows, row, _ROWS, crease_begins)
        for e in range(creases.rows[row], creases.rows[row + 1]):
            x, y, nx, ny = creases.x[e], creases.y[e], creases.nx[e], creases.ny[e]
            beside = 0.0
            for j in range(max(int(y - reach), 0), min(int(y + reach) + 1, height)):
                end = edges.rows[j + 1]
                for k in range(begin_at(begins, j - top, end, edges.x, x - _ALONGSIDE), end):
                    dx, dy = edges.x[k] - x, edges.y[k] - y
                    if dx > reach:
                        break
                    parallel = abs(nx * edges.nx[k] + ny * edges.ny[k]) > _PARALLEL
                    if parallel and dx * dx + dy * dy <= _ALONGSIDE * _ALONGSIDE:
                        beside = max(beside, edges.strength[k])
                end = creases.rows[j + 1]
                for k in range(begin_at(crease_begins, j - top, end, creases.x, x - _ALONGSIDE), end):
                    dx, dy = creases.x[k] - x, creases.y[k] - y
                    if dx > reach:
                        break
                    apart, along = abs(dx * nx + dy * ny), abs(dy * nx - dx * ny)
                    parallel = abs(nx * creases.nx[k] + ny * creases.ny[k]) > _PARALLEL
                    if parallel and along <= 1 and 1 < apart <= _ALONGSIDE and excess[k] > _SHARPER * excess[e]:
                        beside = max(beside, creases.strength[k])
            strength[e] *= 1 - beside


@inlined
def _peak(unit: Array, x: int, y: int, along_x: int, h: float, theta: float, found: Float64) -> bool:
    """Return whether A has a peak between a pixel and the next, and note its strength, offset, normal and excess."""
    middle = _turn(unit, x, y, along_x, 0.5 - h, 0.5 + h)
    if middle <= 0.5 * theta:
        return False
    before, after = _turn(unit, x, y, along_x, -0.5 - h, -0.5 + h), _turn(unit, x, y, along_x, 1.5 - h, 1.5 + h)
    if before > middle or after >= middle:
        return False
    beside = _turn(unit, x, y, along_x, 0.5 - 3 * h, 0.5 - h) + _turn(unit, x, y, along_x, 0.5 + h, 0.5 + 3 * h)
    found[4] = middle - 0.5 * beside
    s = max(h, 1.0)  # the pixel that a fold runs through has the mean of both normals
    near = _turn(unit, x, y, along_x, 0.5 - s - h, 0.5 - s + h) + _turn(unit, x, y, along_x, 0.5 + s - h, 0.5 + s + h)
    sudden = min(middle, 2 * middle - near)
    strength = smoothstep(0.5 * theta, theta, sudden) * smoothstep(0.4 * theta, 0.8 * theta, found[4])
    if strength <= 0:
        return False
    curved = before - 2 * middle + after
    found[0], found[1] = strength, (0.5 * (before - after) / curved if curved < -1e-6 else 0.0)
    xx, xy, yy = 0.0, 0.0, 0.0
    for c in range(3):
        gx, gy = _sobel(unit, x, y, c)
        hx, hy = _sobel(unit, x + along_x, y + 1 - along_x, c)
        gx, gy = gx + hx, gy + hy
        xx, xy, yy = xx + gx * gx, xy + gx * gy, yy + gy * gy
    angle = 0.5 * math.atan2(2 * xy, xx - yy)
    found[2], found[3] = math.cos(angle), math.sin(angle)
    across: bool = abs(found[2] if along_x else found[3]) >= _ACROSS
    return across


@inlined
def _turn(unit: Array, x: int, y: int, along_x: int, start: float, end: float) -> float:
    """Return the angle in degrees between the normals ``start`` and ``end`` pixels along from (x, y); 0 without any."""
    a, b, c = _normal_at(unit, x, y, along_x, start)
    d, e, f = _normal_at(unit, x, y, along_x, end)
    size = (a * a + b * b + c * c) * (d * d + e * e + f * f)
    if size < _NO_NORMAL:
        return 0.0
    return math.degrees(math.acos(min(max((a * d + b * e + c * f) / math.sqrt(size), -1.0), 1.0)))


@inlined
def _normal_at(unit: Array, x: int, y: int, along_x: int, along: float) -> tuple[float, float, float]:
    """Return the normal ``along`` pixels along the row, or the column, from (x, y), between pixels a mean of two."""
    last = (unit.shape[1] if along_x else unit.shape[0]) - 1
    at = min(max((x if along_x else y) + along, 0.0), np.float64(last))
    i = int(at)
    j, t = min(i + 1, last), at - i
    xi, yi = (i, y) if along_x else (x, i)
    xj, yj = (j, y) if along_x else (x, j)
    a = (1 - t) * unit[yi, xi, 0] + t * unit[yj, xj, 0]
    b = (1 - t) * unit[yi, xi, 1] + t * unit[yj, xj, 1]
    c = (1 - t) * unit[yi, xi, 2] + t * unit[yj, xj, 2]
    return a, b, c


@inlined
def _sobel(unit: Array, x: int, y: int, c: int) -> tuple[float, float]:
    """Return the gradient of a component of the normal at a pixel, times 8."""
    height, width = unit.shape[:2]
    left, right, above, below = max(x - 1, 0), min(x + 1, width - 1), max(y - 1, 0), min(y + 1, height - 1)
    gx = unit[above, right, c] + 2 * unit[y, right, c] + unit[below, right, c]
    gx -= unit[above, left, c] + 2 * unit[y, left, c] + unit[below, left, c]
    gy = unit[below, left, c] + 2 * unit[below, x, c] + unit[below, right, c]
    gy -= unit[above, left, c] + 2 * unit[above, x, c] + unit[above, right, c]
    return np.float64(gx), np.float64(gy)
