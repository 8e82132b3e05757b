"""Tangents where there is little or no gradient, from the tensor average around them: push-pull by confidence.

Not in the paper, which leaves holes where the image is constant and rounding noise where it is nearly so.
A tangent t of magnitude m enters as the tensor m^2 t t^T, whose trace is the confidence W = m^2. The field is halved
down to one pixel. Then, coming up, each cell takes its own average tensor with the weight alpha = min(1, W / fill^2),
W the mean over the cell, and the coarser level's, bilinearly, with the rest. Up to its trace a tensor is its double
angle, m^2 (cos 2θ, sin 2θ).

A level is three planes of rows, c, s and W summed over each cell's pixels (so that the smaller cells at the far edges
need no care), or two, the blended c and s. Beyond the cells there are zeros, up to whole vectors and an even height.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters.flow.gradient import half_angle
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, any_lane, lane_indices, maximum, minimum, select, to_floats
from flowabs_nodes.simd.memory import load, load_pairs, store, store_pairs

_ISOTROPIC = 1e-6  # of a trace of 1: a tensor whose double angle is shorter has no direction, only rounding


def flow_fill(
    tangent: Array, magnitude: Array, fill: float, largest: float | None = None, in_place: bool = False
) -> Array:
    """Unit tangents everywhere: (H, W, 2) float32.

    Parameters
    ----------
    tangent, magnitude
        Of the gradient: (H, W, 2) unit or zero, (H, W) in code values per pixel.
    fill
        Magnitude below which a tangent leans on its surroundings, the more the weaker it is; 0 fills only zero
        tangents. Where the surroundings have no direction either, a zero tangent becomes (1, 0).
    largest
        The largest magnitude, if it is known.
    in_place
        Whether ``tangent`` is not needed any more and may be what is returned.
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
    """Fill ``tangent`` itself. It has at least 16 columns; those from ``width`` on are no part of the picture."""
    height, columns = magnitude.shape
    # Confidences are at most 1, so that none overflows; what is 2^-63 of the largest or less counts as none.
    scale = math.ldexp(1, min(-math.frexp(largest)[1], 126))
    confident = min(fill * scale, 1e18) ** 2
    flat, strength = tangent.reshape(-1), magnitude.reshape(-1)
    sums = [_level(3, (height + 1) // 2, (columns + 1) // 2)]
    over_rows(_push_pixels, (height + 1) // 2, flat, strength, np.float32(scale), height, columns, sums[0])
    cells = [((height + 1) // 2, (width + 1) // 2)]
    while cells[-1] != (1, 1):
        cells.append(((cells[-1][0] + 1) // 2, (cells[-1][1] + 1) // 2))
        sums.append(_level(3, *cells[-1]))
        over_rows(_push, cells[-1][0], sums[-2], sums[-1], least=_worth_a_thread(cells[-1]))
    weight = sums[-1][2, 0, 0]
    axes = sums.pop()[:2] / np.float32(weight if weight > 0 else 1)
    for level in range(len(sums), 0, -1):
        coarser, axes = axes, _level(2, *cells[level - 1])
        rows, arguments = (
            cells[level - 1][0],
            (sums.pop(), coarser, cells[level], confident, 2**level, height, width, axes),
        )
        over_rows(_pull, rows, *arguments, least=_worth_a_thread(cells[level - 1]))
    over_rows(_pull_pixels, height, flat, strength, np.float32(scale), axes, cells[0], np.float32(confident), columns)


def _worth_a_thread(cells: tuple[int, int]) -> int:
    """So many rows of a level that it takes longer to fill them than to wake a thread."""
    return max(8, 2**15 // cells[1])


def _level(planes: int, rows: int, cells: int) -> Array:
    return np.zeros((planes, rows + rows % 2, -(-cells // (2 * LANES)) * 2 * LANES), np.float32)


@inlined
def _weighted(tangent: Array, magnitude: Array, scale: float, i: int) -> Any:
    """m^2 (cos 2θ, sin 2θ) and m^2 of sixteen pixels; all zero where there is no tangent."""
    tx, ty = load_pairs(tangent, 2 * i)
    m = load(magnitude, i) * scale
    xx, yy = tx * tx, ty * ty
    weight = select(xx + yy > 0.0, m * m, 0.0)
    return weight * (xx - yy), weight * (2.0 * tx * ty), weight


@kernel
def _push_pixels(
    first: int, last: int, tangent: Array, magnitude: Array, scale: float, height: int, width: int, sums: Array
) -> None:
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
    for j in range(first, last):
        for p in range(3):
            _halve(fine[p, 2 * j], fine[p, 2 * j + 1], sums[p, j])


@inlined
def _halve(upper: Array, lower: Array, sums: Array) -> None:
    """Sums of 2 x 2."""
    for i in range(0, min(upper.size // 2, sums.size), LANES):
        a, b = load_pairs(upper, 2 * i)
        c, d = load_pairs(lower, 2 * i)
        store(sums, i, (a + b) + (c + d))


@inlined
def _bilinear(coarse: Array, cells: tuple[int, int], y: int, blended: Array, fine: Array) -> None:
    """A plane of the coarser level at the centres of row y of the finer: cell j covers the finer 2j and 2j + 1."""
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
    """alpha (c, s) / weight + (1 - alpha) below, alpha = min(1, weight / confident); below where the weight is 0."""
    inverse = select(weight > 0.0, 1.0 / maximum(weight, confident), 0.0)
    rest = 1.0 - weight * inverse
    return c * inverse + rest * below_c, s * inverse + rest * below_s


@kernel
def _pull(
    first: int,
    last: int,
    sums: Array,
    coarser: Array,
    cells: tuple[int, int],
    confident: float,
    size: int,
    height: int,
    width: int,
    axes: Array,
) -> None:
    """``cells``: of the coarser level, its rows and columns. ``size``: pixels that a cell of this level is wide."""
    blended = np.empty(coarser.shape[2] + 2, np.float32)
    below_c, below_s = np.empty(2 * coarser.shape[2], np.float32), np.empty(2 * coarser.shape[2], np.float32)
    for j in range(first, last):
        _bilinear(coarser[0], cells, j, blended, below_c)
        _bilinear(coarser[1], cells, j, blended, below_s)
        rows = np.float32(confident * min(size, height - j * size))
        for i in range(0, min(2 * cells[1], axes.shape[2]), LANES):
            area = rows * to_floats(minimum(width - (lane_indices() + i) * size, size))
            own = load(sums[0, j], i), load(sums[1, j], i), load(sums[2, j], i)
            c, s = _lean(own[0], own[1], own[2], area, load(below_c, i), load(below_s, i))
            store(axes[0, j], i, c)
            store(axes[1, j], i, s)


@kernel
def _pull_pixels(
    first: int,
    last: int,
    tangent: Array,
    magnitude: Array,
    scale: float,
    coarser: Array,
    cells: tuple[int, int],
    confident: float,
    width: int,
) -> None:
    blended = np.empty(coarser.shape[2] + 2, np.float32)
    below_c, below_s = np.empty(2 * coarser.shape[2], np.float32), np.empty(2 * coarser.shape[2], np.float32)
    for y in range(first, last):
        if confident == 0 and not _any_missing(tangent, y * width, width):
            continue
        _bilinear(coarser[0], cells, y, blended, below_c)
        _bilinear(coarser[1], cells, y, blended, below_s)
        for x0 in range(0, width, LANES):
            x = min(x0, width - LANES)
            i = y * width + x
            c, s, weight = _weighted(tangent, magnitude, scale, i)
            tx, ty = load_pairs(tangent, 2 * i)
            missing = tx * tx + ty * ty == 0.0
            # Those that the block before has filled are not filled again.
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
    """Whether a row of pixels has a zero tangent."""
    for x0 in range(0, width, LANES):
        tx, ty = load_pairs(tangent, 2 * (first + min(x0, width - LANES)))
        if any_lane(tx * tx + ty * ty == 0.0):
            return True
    return False
