"""Boil: lines drawn anew every few frames, each time a little elsewhere, as a hand does it.

Every ``hold`` frames there is a new smooth field of vectors v, |v| at most 1 (``smooth_noise.py``). It moves the ink
across the strokes, where it shows; along them only their ends would move, and what they are made of would slide. With
the flow's tensor T = mean of t t^T around x (a Gaussian of sigma 2),

    lines'(x) = lines(x + amount d(x)),    d = v - T v.

On a stroke T is t t^T, and d the part of v along the normal, whichever way the flow's sign points. Where strokes cross
or turn T is nearer to I/2, and they move together by v/2: nothing is torn apart. Lines are read by Catmull-Rom's cubic,
which keeps the blackness of thin strokes and their width (of 1.5 pixels within 2 %; one of a single pixel comes out 8 %
darker), but for what the field stretches: at most 3.75 amount / size, on average a tenth of that.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters import halo, validate
from flowabs_nodes.filters.gaussian_blur import blur
from flowabs_nodes.filters.motion.smooth_noise import Field, smooth_noise
from flowabs_nodes.sampling.coords import Raster
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import (
    LANES,
    Floats,
    absolute,
    any_lane,
    floor,
    lane_indices,
    maximum,
    minimum,
    splat_floats,
    to_ints,
)
from flowabs_nodes.simd.memory import gather_pairs, gather_quads, load, load_pairs, scratch, store, store_pairs
from flowabs_nodes.simd.pixelwise import as_picture, as_run, empty_run, first_pixel, over_pixels


def boil(
    lines: npt.ArrayLike,
    flow: npt.ArrayLike,
    amount: float = 0.0,
    hold: int = 2,
    size: float = 40.0,
    seed: int = 1,
    frame: int = 1,
    origin: tuple[int, int] = (0, 0),
) -> Array:
    """Return a drawing whose ink is displaced by chance, (H, W) float32, 0 to 1.

    Parameters
    ----------
    lines
        (H, W), 1 paper and 0 ink.
    flow
        (H, W, 2), unit tangents, x right and y down; the sign has no meaning. The flow that the lines follow.
    amount
        How far ink is displaced at most, 0 to 100 pixels; about half as far on average. 0 gives the very lines.
    hold
        For how many frames a drawing stays, at least 1: frames 1 to ``hold`` have the first field.
    size
        How far apart displacements know nothing of each other, 1 to 10,000 pixels.
    seed
        Which fields, 0 to 2^31 - 1.
    frame
        The frame's number. It alone says which field it is, so that frames may be drawn in any order.
    origin
        Where the first pixel lies in the whole picture, x and y: the parts of a picture fit together.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    lines = validate.plane("lines", lines)
    flow = validate.flow_field(flow, lines.shape)
    amount = validate.number("amount", amount, min=0, max=100)
    hold = validate.whole("hold", hold, min=1)
    size = validate.number("size", size, min=1, max=10_000)
    seed = validate.whole("seed", seed, min=0, max=2**31 - 1)
    number = field_number(validate.whole("frame", frame), hold)
    if amount == 0:
        return lines.copy()
    height, width = lines.shape
    field = smooth_noise((height, width), origin, size, seed, number)
    margin = halo.boil_reach(amount)
    beside = max(LANES - width, 0)  # rows of at least sixteen pixels
    drawing = np.pad(1 - lines, [(margin, margin), (margin, margin + beside)], "edge")  # ink: nothing stays nothing
    directions = np.pad(blur(_double_angles(flow), halo.BOIL_EASE), [(0, 0), (0, beside), (0, 0)])
    field = field._replace(columns=np.pad(field.columns, (0, beside)), across=np.pad(field.across, (0, beside)))
    raster = Raster(width + beside, height, drawing.shape[1])
    inked = np.empty((len(drawing), -(-raster.stride // LANES)), np.bool_)
    over_rows(_find_ink, len(drawing), drawing, inked)
    moved = np.empty((height, raster.width), np.float32)
    over_rows(
        _move,
        height,
        drawing.reshape(-1),
        inked,
        directions.reshape(-1),
        field,
        np.float32(amount),
        margin,
        raster,
        moved.reshape(-1),
    )
    return np.ascontiguousarray(moved[:, :width])


def field_number(frame: int, hold: int) -> int:
    """Return the number of the field that a frame is drawn with."""
    return (frame - 1) // hold


def _double_angles(flow: Array) -> Array:
    """Return (t.x^2 - t.y^2, 2 t.x t.y) of each tangent, (H, W, 2): with T.xx + T.yy = 1, all of t t^T."""
    run = as_run(flow, 2)
    angles = empty_run(flow.size // 2, 2)
    over_pixels(_double, run.size // 2, run, angles)
    return as_picture(angles, *flow.shape)


@kernel
def _double(first: int, last: int, flow: Array, angles: Array) -> None:
    """Write the blocks ``first`` .. ``last`` - 1 of sixteen pixels."""
    for block in range(first, last):
        i = first_pixel(block, flow.size // 2)
        tx, ty = load_pairs(flow, 2 * i)
        store_pairs(angles, 2 * i, (tx * tx - ty * ty, 2.0 * (tx * ty)))


@kernel
def _find_ink(first: int, last: int, drawing: Array, inked: npt.NDArray[np.bool_]) -> None:
    """Write for the rows ``first`` .. ``last`` - 1 which of their blocks of sixteen pixels hold ink."""
    stride = drawing.shape[1]
    for y in range(first, last):
        for block in range(inked.shape[1]):
            inked[y, block] = any_lane(absolute(load(drawing[y], min(LANES * block, stride - LANES))) > 0.0)


@kernel
def _move(
    first: int,
    last: int,
    drawing: Array,
    inked: npt.NDArray[np.bool_],
    directions: Array,
    field: Field,
    amount: float,
    margin: int,
    raster: Raster,
    moved: Array,
) -> None:
    """Write the rows ``first`` .. ``last`` - 1 of the displaced drawing, (H, W) flattened.

    ``drawing``, the ink, has its border repeated ``margin`` times to each side; its rows are ``raster.stride`` long.
    """
    count = field.vectors.shape[2]
    along_row = np.empty((2, count), np.float32)
    place = scratch(np.int32, 1)
    for y in range(first, last):
        j, down = field.rows[y], field.down[y]
        for part in range(2):
            for i in range(count):
                above, below = field.vectors[part, j, i], field.vectors[part, j + 1, i]
                along_row[part, i] = above + down * (below - above)
        for x0 in range(0, raster.width, LANES):
            x = min(x0, raster.width - LANES)
            if not _any_ink(inked, y, x, margin):
                store(moved, y * raster.width + x, splat_floats(1.0))
                continue
            vx = _between(along_row[0], field, x)
            vy = _between(along_row[1], field, x)
            c, s = load_pairs(directions, 2 * (y * raster.width + x))
            # d = v - T v, T = ((1 + c, s), (s, 1 - c)) / 2
            dx = amount * 0.5 * (vx - c * vx - s * vy)
            dy = amount * 0.5 * (vy - s * vx + c * vy)
            left, top = floor(dx), floor(dy)
            store(
                place,
                0,
                (to_ints(top) + (y + margin - 1)) * raster.stride + to_ints(left) + (lane_indices() + (x + margin - 1)),
            )
            ink = _cubic(drawing, place, dx - left, dy - top, raster.stride)
            store(moved, y * raster.width + x, 1.0 - minimum(maximum(ink, 0.0), 1.0))


@inlined
def _any_ink(inked: npt.NDArray[np.bool_], y: int, x: int, margin: int) -> bool:
    """Return whether there is ink within ``margin`` of the pixels x .. x + 15 of row y."""
    for row in range(y, y + 2 * margin + 1):
        for block in range(x // LANES, (x + LANES - 1 + 2 * margin) // LANES + 1):
            if inked[row, block]:
                return True
    return False


@inlined
def _between(row: Array, field: Field, x: int) -> Floats:
    """Return one part of v at the pixels x .. x + 15, from its values at the lattice's columns."""
    before, after = gather_pairs(row, field.columns, x)
    return before + load(field.across, x) * (after - before)


@inlined
def _cubic(drawing: Array, place: Array, u: Floats, v: Floats, stride: int) -> Floats:
    """Return sixteen samples by Catmull-Rom's cubic (``sampling/resolution.py``).

    ``place`` holds the upper left one of the 4 x 4 pixels around each; u and v, 0 to 1, are the ways from the second.
    """
    p, q, r, s = _weights(v)
    above = _along(drawing, place, u)
    here = _along(drawing[stride:], place, u)
    below = _along(drawing[2 * stride :], place, u)
    last = _along(drawing[3 * stride :], place, u)
    return p * above + q * here + r * below + s * last


@inlined
def _along(drawing: Array, place: Array, u: Floats) -> Floats:
    """Return the samples along one row of four pixels."""
    a, b, c, d = gather_quads(drawing, place, 0)
    p, q, r, s = _weights(u)
    return p * a + q * b + r * c + s * d


@inlined
def _weights(t: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the weights of four neighbours of a point that is t beyond the second one."""
    p = t * (t * (1.0 - 0.5 * t) - 0.5)
    q = 1.0 + t * t * (1.5 * t - 2.5)
    r = t * (t * (2.0 - 1.5 * t) + 0.5)
    return p, q, r, t * t * (0.5 * t - 0.5)
