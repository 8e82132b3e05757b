"""Bring a smoothed picture up to full size, with the full picture as guide: each channel by a line of its own.

Around each reduced pixel, over 3 x 3 of them, the smoothed picture is fitted by a x + b, x being the reduced picture
that was smoothed (He, Sun, Tang: "Guided image filtering", 2013, whose a and b these are):

    a = cov(x, smoothed) / (var(x) + eps),    b = mean(smoothed) - a mean(x)

a and b are brought up linearly and applied to the picture at full size (He, Sun: "Fast guided filter", 2015): where the
smoothing left an edge, a is 1 and the edge is as sharp as it was; where it smoothed detail away, a is 0 and nothing of
the detail comes back. The line of a single reduced pixel is taken as it is, not the mean of nine as in the papers:
nearer by a tenth to what smoothing at full size gives, and less to compute. Joint bilateral upsampling (Kopf et al.
2007) leaves half as much again at edges, which become jagged.
"""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.sampling.resolution import Enlargement, enlarge_row, linear_phases, new_column, planes_to_enlarge
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.lanes import LANES, from_doubles, maximum, minimum, select, splat_doubles, to_doubles
from flowabs_nodes.simd.memory import load, load_triples, store, store_triples

#: eps in code values squared: how much a channel has to vary for its detail to be told from noise.
_EPSILON = 10.0
#: The steepest a: smoothing makes few edges steeper than this. It keeps pictures of enormous numbers finite.
_STEEPEST = 4.0


def upsampled(
    codes: Array, small: Array, smoothed: Array, factor: int, alpha: Array | None, covered: Array | None
) -> Array:
    """Return ``smoothed`` brought up to full size, (H, W, 3) float32.

    Parameters
    ----------
    codes
        The picture at full size, code values (H, W, 3).
    small
        The picture reduced, (h, w, 3).
    smoothed
        What a filter made of ``small``, (h, w, 3).
    factor
        2 or 4.
    alpha
        Coverage at full size, (H, W): a pixel of 0 or less stays as it is. None is 1 everywhere.
    covered
        Coverage reduced, (h, w): what each reduced pixel counts. None is 1 everywhere.
    """
    return applied(fitted(small, smoothed, covered), codes, factor, alpha)


def fitted(small: Array, smoothed: Array, covered: Array | None) -> Array:
    """Return a of the three channels and then b, (6, h, w), for :func:`applied`; all are as in :func:`upsampled`."""
    height, width, _ = small.shape
    beyond = max(1, LANES + 1 - width)  # columns to the right: rows have at least sixteen pixels
    around = np.empty((6, height + 2, 1 + width + beyond), np.float32)

    def lay_out(first: int, last: int) -> None:
        """Copy rows as planes; the border is repeated at both sides."""
        rows = around[:, 1 + first : 1 + last]
        rows[:3, :, 1 : 1 + width] = np.moveaxis(small[first:last], 2, 0)
        rows[3:, :, 1 : 1 + width] = np.moveaxis(smoothed[first:last], 2, 0)
        rows[..., 0], rows[..., 1 + width :] = rows[..., 1], rows[..., width, None]

    over_rows(lay_out, height)
    around[:, 0], around[:, -1] = around[:, 1], around[:, -2]
    counts = np.ones((height, width), np.float32) if covered is None else covered
    weights = np.ascontiguousarray(np.pad(counts, ((1, 1), (1, beyond)), "edge"))
    lines = np.empty((6, height, around.shape[2] - 2), np.float32)
    over_rows(_fit, height, around, weights, lines)
    return np.ascontiguousarray(lines[..., :width])


def applied(
    lines: Array, codes: Array, factor: int, alpha: Array | None, first: int = 0, last: int | None = None
) -> Array:
    """Return a x + b at full size, x being ``codes``, for the rows ``first`` .. ``last`` - 1 of the picture, or all.

    ``codes`` and ``alpha`` are the whole picture's.
    """
    codes, alpha = codes[first:last], None if alpha is None else alpha[first:last]
    height, width = codes.shape[:2]
    small, how = planes_to_enlarge(lines, linear_phases(factor))
    beside = max(0, LANES - width)  # columns that are cut off again
    if beside:
        codes = np.pad(codes, ((0, 0), (0, beside), (0, 0)))
        alpha = None if alpha is None else np.pad(alpha, ((0, 0), (0, beside)))
    result = np.empty_like(codes)
    shares = None if alpha is None else alpha.reshape(-1)
    over_rows(_apply, height, codes.reshape(-1), shares, small, how, first, result.reshape(-1), codes.shape[1])
    return np.ascontiguousarray(result[:, :width])


@kernel
def _fit(first: int, last: int, planes: Array, weights: Array, lines: Array) -> None:
    """Fit the lines of rows ``first`` .. ``last`` - 1. ``planes`` and ``weights`` have a rim of a pixel all around.

    All sums are of differences from the pixel in the middle: constant pictures stay exactly what they are.
    """
    width = lines.shape[2]
    for y in range(first, last):
        for c in range(3):
            for x0 in range(0, width, LANES):
                i = min(x0, width - LANES)
                middle = to_doubles(load(planes[c, y + 1], i + 1))
                made = to_doubles(load(planes[3 + c, y + 1], i + 1))
                count, sx, sz = splat_doubles(0.0), splat_doubles(0.0), splat_doubles(0.0)
                sxx, sxz = splat_doubles(0.0), splat_doubles(0.0)
                for dy in range(3):
                    for dx in range(3):
                        weight = to_doubles(load(weights[y + dy], i + dx))
                        x = to_doubles(load(planes[c, y + dy], i + dx)) - middle
                        z = to_doubles(load(planes[3 + c, y + dy], i + dx)) - made
                        count, sx, sz = count + weight, sx + weight * x, sz + weight * z
                        sxx, sxz = sxx + weight * (x * x), sxz + weight * (x * z)
                over = select(count > 0.0, 1.0 / count, 0.0)
                sx, sz = sx * over, sz * over
                slope = (sxz * over - sx * sz) / (maximum(sxx * over - sx * sx, 0.0) + _EPSILON)
                slope = minimum(maximum(slope, -_STEEPEST), _STEEPEST)
                store(lines[c, y], i, from_doubles(slope))
                store(lines[3 + c, y], i, from_doubles(made + sz - slope * (middle + sx)))


@kernel
def _apply(
    first: int,
    last: int,
    codes: Array,
    alpha: Array | None,
    lines: Array,
    how: Enlargement,
    start: int,
    result: Array,
    stride: int,
) -> None:
    """Write a x + b of rows ``first`` .. ``last`` - 1, of which row 0 is row ``start`` of the picture.

    ``codes`` and ``result`` are (H, stride, 3), flattened.
    """
    column, rows = new_column(how), np.empty((6, how.factor * how.stride), np.float32)
    for y in range(first, last):
        for p in range(6):
            enlarge_row(lines[p], start + y, how, column, rows[p])
        for x0 in range(0, stride, LANES):
            x = min(x0, stride - LANES)
            pixel = y * stride + x
            l, a, b = load_triples(codes, 3 * pixel)  # noqa: E741
            new_l = load(rows[0], x) * l + load(rows[3], x)
            new_a = load(rows[1], x) * a + load(rows[4], x)
            new_b = load(rows[2], x) * b + load(rows[5], x)
            if alpha is not None:
                there = load(alpha, pixel) > 0.0
                new_l, new_a, new_b = select(there, new_l, l), select(there, new_a, a), select(there, new_b, b)
            store_triples(result, 3 * pixel, (new_l, new_a, new_b))
