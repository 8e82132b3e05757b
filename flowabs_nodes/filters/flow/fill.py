"""Fill tangents where there is little or no gradient from the tensor average around them: push-pull by confidence.

The paper leaves holes where the image is constant, and rounding noise where it is nearly so. Here a tangent t of
magnitude m counts as the tensor m^2 t t^T, whose trace W = m^2 is the *confidence*. Its double angle is (c, s) =
m^2 (cos 2θ, sin 2θ), θ the angle of t; c, s and W add up. Two sweeps over a pyramid (The Lumigraph, Gortler et al.):

- *Push*: sums over 2 x 2 cells, level by level, down to one cell.
- *Pull*: coming up again, each cell blends its own average tensor, with the weight alpha = min(1, W / fill^2) where W
  is the mean over the cell, with the coarser level's tensors, read bilinearly, with the weight 1 - alpha.

A level is an array (planes, rows, columns): three planes c, s and W, sums over the pixels of each cell (so that the
smaller cells at the right and bottom edges need no care), or two planes of blended c and s, for a trace of 1. Rows are
padded with zeros to whole vectors, and to an even number of rows.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters.flow.gradient import half_angle
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, any_lane, lane_indices, maximum, minimum, select, to_floats
from flowabs_nodes.simd.memory import load, load_pairs, store, store_pairs

_ISOTROPIC = 1e-6  # a tensor of trace 1 whose double angle is shorter than this has no direction, only rounding


class Blended(NamedTuple):
    """A level of blended tensors of trace 1."""

    planes: Array  # (2, rows, columns): c and s
    cells: tuple[int, int]  # the rows and columns that are cells, not padding


def flow_fill(
    tangent: Array, magnitude: Array, fill: float, largest: float | None = None, in_place: bool = False
) -> Array:
    """Return a unit tangent for every pixel, weak ones drawn towards the tensor average of their surroundings.

    Parameters
    ----------
    tangent
        Tangents of the gradient, (H, W, 2), unit or zero.
    magnitude
        Magnitude of the gradient, (H, W), in code values per pixel.
    fill
        Magnitude below which a tangent leans on its surroundings, the more the weaker it is; 0 fills only zero
        tangents. Where the surroundings have no direction either, a zero tangent becomes (1, 0).
    largest
        The largest magnitude, if it is known.
    in_place
        Whether ``tangent`` may be overwritten and returned.

    Returns
    -------
    (H, W, 2) float32 unit vectors.
    """
    width = magnitude.shape[1]
    if width >= LANES:
        filled = tangent if in_place else tangent.copy()
        _fill(filled, magnitude, fill, float(magnitude.max()) if largest is None else largest, width)
        return filled
    beside = LANES - width
    filled, wide = np.pad(tangent, [(0, 0), (0, beside), (0, 0)]), np.pad(magnitude, [(0, 0), (0, beside)])
    _fill(filled, wide, fill, float(magnitude.max()), width)
    return np.ascontiguousarray(filled[:, :width])


def _fill(tangent: Array, magnitude: Array, fill: float, largest: float, width: int) -> None:
    """Fill ``tangent``, at least sixteen columns, in place; the columns from ``width`` on are padding."""
    height, columns = magnitude.shape
    # Scaled magnitudes are below 1, so no confidence overflows; 2^-63 of the largest magnitude or less counts as none.
    scale = math.ldexp(1, min(-math.frexp(largest)[1], 126))
    confident = min(fill * scale, 1e18) ** 2
    flat, strength = tangent.reshape(-1), magnitude.reshape(-1)
    cells = [((height + 1) // 2, (width + 1) // 2)]
    sums = [_new_level(3, (height + 1) // 2, (columns + 1) // 2)]
    over_rows(_push_pixels, (height + 1) // 2, flat, strength, np.float32(scale), height, columns, sums[0])
    while cells[-1] != (1, 1):
        cells.append(((cells[-1][0] + 1) // 2, (cells[-1][1] + 1) // 2))
        sums.append(_new_level(3, *cells[-1]))
        over_rows(_push, cells[-1][0], sums[-2], sums[-1], least=_worth_a_thread(cells[-1]))
    weight = sums[-1][2, 0, 0]
    coarser = Blended(sums.pop()[:2] / np.float32(weight if weight > 0 else 1), cells[-1])
    for level in range(len(sums), 0, -1):
        finer = Blended(_new_level(2, *cells[level - 1]), cells[level - 1])
        arguments = sums.pop(), coarser, confident, 2**level, (height, width), finer.planes
        over_rows(_pull, finer.cells[0], *arguments, least=_worth_a_thread(finer.cells))
        coarser = finer
    over_rows(_pull_pixels, height, flat, strength, np.float32(scale), coarser, np.float32(confident), columns)


def _worth_a_thread(cells: tuple[int, int]) -> int:
    """Return how many rows of a level take longer to fill than it takes to wake a thread."""
    return max(8, 2**15 // cells[1])


def _new_level(planes: int, rows: int, columns: int) -> Array:
    """Return zeros for ``rows`` x ``columns`` cells, padded."""
    return np.zeros((planes, rows + rows % 2, -(-columns // (2 * LANES)) * 2 * LANES), np.float32)


@inlined
def _weighted(tangent: Array, magnitude: Array, scale: float, i: int) -> Any:
    """Return c, s and W of the sixteen pixels from i on, magnitudes times ``scale``; 0 where the tangent is zero."""
    tx, ty = load_pairs(tangent, 2 * i)
    m = load(magnitude, i) * scale
    xx, yy = tx * tx, ty * ty
    weight = select(xx + yy > 0.0, m * m, 0.0)
    return weight * (xx - yy), weight * (2.0 * tx * ty), weight


@kernel
def _push_pixels(
    first: int, last: int, tangent: Array, magnitude: Array, scale: float, height: int, width: int, sums: Array
) -> None:
    """Write the rows ``first`` .. ``last`` - 1 of the finest level of sums, from the pixels of twice as many rows.

    ``tangent`` is (H, W, 2) flattened, ``magnitude`` (H, W), ``sums`` (3, rows, columns).
    """
    rows = np.zeros((2, 3, 2 * sums.shape[2]), np.float32)
    for j in range(first, last):
        for k in range(2):
            if 2 * j + k == height:
                rows[k] = 0
                break
            for x0 in range(0, width, LANES):
                x = min(x0, width - LANES)
                c, s, weight = _weighted(tangent, magnitude, scale, (2 * j + k) * width + x)
                store(rows[k, 0], x, c)
                store(rows[k, 1], x, s)
                store(rows[k, 2], x, weight)
        for p in range(3):
            _halve(rows[0, p], rows[1, p], sums[p, j])


@kernel
def _push(first: int, last: int, fine: Array, sums: Array) -> None:
    """Write the rows ``first`` .. ``last`` - 1 of a level of sums, from the next finer one; both (3, rows, columns)."""
    for j in range(first, last):
        for p in range(3):
            _halve(fine[p, 2 * j], fine[p, 2 * j + 1], sums[p, j])


@inlined
def _halve(upper: Array, lower: Array, sums: Array) -> None:
    """Write the sums of 2 x 2 cells of two neighbouring rows into one row."""
    for i in range(0, min(upper.size // 2, sums.size), LANES):
        a, b = load_pairs(upper, 2 * i)
        c, d = load_pairs(lower, 2 * i)
        store(sums, i, (a + b) + (c + d))


@inlined
def _bilinear(coarse: Array, cells: tuple[int, int], y: int, blended: Array, fine: Array) -> None:
    """Write one plane of a coarser level, read bilinearly at the centres of row y of the finer level, into ``fine``.

    Cell j of the coarser level covers the finer cells 2j and 2j + 1; its border is repeated. ``cells`` are its rows and
    columns, ``blended`` is room for one of its rows and a cell at either end.
    """
    j = y // 2
    near, far = coarse[j], coarse[min(max(j + 2 * (y % 2) - 1, 0), cells[0] - 1)]
    for i in range(0, cells[1], LANES):
        store(blended, 1 + i, 0.75 * load(near, i) + 0.25 * load(far, i))
    blended[0], blended[cells[1] + 1] = blended[1], blended[cells[1]]
    for i in range(0, cells[1], LANES):
        here = 0.75 * load(blended, i + 1)
        store_pairs(fine, 2 * i, (here + 0.25 * load(blended, i), here + 0.25 * load(blended, i + 2)))


@inlined
def _lean(c: Any, s: Any, weight: Any, confident: Any, below_c: Any, below_s: Any) -> Any:
    """Return alpha (c, s) / weight + (1 - alpha) (below_c, below_s), alpha = min(1, weight / confident).

    Where the weight is 0, (below_c, below_s).
    """
    inverse = select(weight > 0.0, 1.0 / maximum(weight, confident), 0.0)
    rest = 1.0 - weight * inverse
    return c * inverse + rest * below_c, s * inverse + rest * below_s


@kernel
def _pull(
    first: int,
    last: int,
    sums: Array,
    coarser: Blended,
    confident: float,
    size: int,
    picture: tuple[int, int],
    blended: Array,
) -> None:
    """Write the rows ``first`` .. ``last`` - 1 of a level of blended tensors, (2, rows, columns).

    Parameters
    ----------
    sums
        c, s and W of this level, (3, rows, columns).
    coarser
        The next coarser level.
    confident
        Confidence of a pixel, in the scale of ``sums``, from which it does not lean on the coarser level.
    size
        Number of pixels that a cell of this level is wide and high, but for the last of a row or column.
    picture
        Height and width in pixels.
    """
    coarse, cells = coarser
    height, width = picture
    room = np.empty(coarse.shape[2] + 2, np.float32)
    below_c, below_s = np.empty(2 * coarse.shape[2], np.float32), np.empty(2 * coarse.shape[2], np.float32)
    for j in range(first, last):
        _bilinear(coarse[0], cells, j, room, below_c)
        _bilinear(coarse[1], cells, j, room, below_s)
        confident_column = np.float32(confident * min(size, height - j * size))
        for i in range(0, min(2 * cells[1], blended.shape[2]), LANES):
            confident_cell = confident_column * to_floats(minimum(width - (lane_indices() + i) * size, size))
            own = load(sums[0, j], i), load(sums[1, j], i), load(sums[2, j], i)
            c, s = _lean(own[0], own[1], own[2], confident_cell, load(below_c, i), load(below_s, i))
            store(blended[0, j], i, c)
            store(blended[1, j], i, s)


@kernel
def _pull_pixels(
    first: int,
    last: int,
    tangent: Array,
    magnitude: Array,
    scale: float,
    coarser: Blended,
    confident: float,
    width: int,
) -> None:
    """Fill the tangents of the rows ``first`` .. ``last`` - 1 in place.

    Parameters
    ----------
    tangent, magnitude
        (H, W, 2) and (H, W), flattened.
    scale
        Factor of magnitudes.
    coarser
        The finest level, whose cells are 2 x 2 pixels.
    confident
        Confidence from which a tangent stays as it is; 0 fills only zero tangents.
    width
        W, at least sixteen.
    """
    coarse, cells = coarser
    room = np.empty(coarse.shape[2] + 2, np.float32)
    below_c, below_s = np.empty(2 * coarse.shape[2], np.float32), np.empty(2 * coarse.shape[2], np.float32)
    for y in range(first, last):
        if confident == 0 and not _any_missing(tangent, y * width, width):
            continue
        _bilinear(coarse[0], cells, y, room, below_c)
        _bilinear(coarse[1], cells, y, room, below_s)
        for x0 in range(0, width, LANES):
            x = min(x0, width - LANES)
            i = y * width + x
            c, s, weight = _weighted(tangent, magnitude, scale, i)
            tx, ty = load_pairs(tangent, 2 * i)
            missing = tx * tx + ty * ty == 0.0
            # The last block overlaps the one before it, whose pixels are filled already.
            weak = (missing | (weight < confident)) & (lane_indices() + x >= x0)
            if any_lane(weak):
                c, s = _lean(c, s, weight, confident, load(below_c, x), load(below_s, x))
                new_x, new_y = half_angle(c, s)
                directed = weak & (c * c + s * s > _ISOTROPIC**2)
                tx = select(directed, new_x, select(missing, 1.0, tx))
                ty = select(directed, new_y, ty)
                store_pairs(tangent, 2 * i, (tx, ty))


@inlined
def _any_missing(tangent: Array, first: int, width: int) -> bool:
    """Return whether the row of ``width`` pixels that begins with pixel ``first`` has a zero tangent."""
    for x0 in range(0, width, LANES):
        tx, ty = load_pairs(tangent, 2 * (first + min(x0, width - LANES)))
        if any_lane(tx * tx + ty * ty == 0.0):
            return True
    return False
