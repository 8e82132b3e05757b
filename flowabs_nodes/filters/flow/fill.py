"""Fill tangents where there is little or no gradient from the tensor average around them: a normalised convolution.

The paper leaves holes where the image is constant, and rounding noise where it is nearly so. Here a tangent t of
magnitude m has the *certainty* alpha = min(1, m^2 / fill^2) and counts as the tensor W t t^T of weight W = alpha m^2.
With (c, s) = W (cos 2θ, sin 2θ), θ the angle of t, the tensor average around a pixel is

    (c', s') = sum_y K(x - y) (c, s)(y) / sum_y K(x - y) W(y)

(normalised convolution, Knutsson and Westin 1993). The filled tangent is at half the angle of alpha (cos 2θ, sin 2θ) +
(1 - alpha) (c', s'). K is a sum of Gaussians of growing scale, each twice as wide as the one before and of half its
weight, so K falls off as distance^-3: near tangents count most, far ones count where nothing is near, and the direction
changes smoothly. The sums do not depend on where the pixel grid lies (``gaussian_pyramid.py``).
"""

from __future__ import annotations

import math

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters.flow.gaussian_pyramid import (
    MARGIN,
    RING,
    enlarge_rows,
    enlarged_row,
    first_level,
    halve_row,
    smooth_rows,
    sum_over_scales,
)
from flowabs_nodes.filters.flow.gradient import half_angle
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, Floats, any_lane, lane_indices, minimum, select
from flowabs_nodes.simd.memory import load, load_pairs, store, store_pairs

_ISOTROPIC = 1e-6  # a tensor of trace 1 whose double angle is shorter than this has no direction, only rounding


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
    largest = float(magnitude.max()) if largest is None else largest
    width = magnitude.shape[1]
    if width >= LANES:
        filled = tangent if in_place else tangent.copy()
        _fill(filled, magnitude, fill, largest)
        return filled
    beside = LANES - width  # columns of zeros, which count as little as what lies outside the picture
    filled, wide = np.pad(tangent, [(0, 0), (0, beside), (0, 0)]), np.pad(magnitude, [(0, 0), (0, beside)])
    _fill(filled, wide, fill, largest)
    return np.ascontiguousarray(filled[:, :width])


def _fill(tangent: Array, magnitude: Array, fill: float, largest: float) -> None:
    """Fill ``tangent``, at least sixteen columns, in place."""
    height, width = magnitude.shape
    # Scaled magnitudes are below 1, so no weight overflows; 2^-63 of the largest magnitude or less counts as none.
    scale = math.ldexp(1, min(-math.frexp(largest)[1], 126))
    certain = min(fill * scale, 1e18) ** 2
    pixels = tangent.reshape(-1), magnitude.reshape(-1), np.float32(scale)
    level = first_level(3, height, width)
    # Weights are only compared with each other, so they need not become as small as the certainties of a huge ``fill``.
    weighing = *pixels, np.float32(min(certain, 1.0)), height, width, level
    over_rows(_push_pixels, level.shape[1], *weighing, least=32)
    sum_over_scales(level, height, width)
    over_rows(_pull_pixels, height, *pixels, np.float32(certain), width, level)


@inlined
def _weighted(tangent: Array, magnitude: Array, scale: float, certain: float, i: int) -> tuple[Floats, Floats, Floats]:
    """Return c, s and W of the sixteen pixels from i on, magnitudes times ``scale``; 0 where the tangent is zero."""
    tx, ty = load_pairs(tangent, 2 * i)
    m = load(magnitude, i) * scale
    xx, yy = tx * tx, ty * ty
    power = m * m
    weight = select(xx + yy > 0.0, power * select(power < certain, power / certain, 1.0), 0.0)
    return weight * (xx - yy), weight * (2.0 * tx * ty), weight


@kernel
def _push_pixels(
    first: int,
    last: int,
    tangent: Array,
    magnitude: Array,
    scale: float,
    certain: float,
    height: int,
    width: int,
    level: Array,
) -> None:
    """Write the rows ``first`` .. ``last`` - 1 of the first level from the pixels.

    ``tangent`` is (H, W, 2) flattened, ``magnitude`` (H, W). ``certain`` is fill^2 in the scale of ``scale``.
    """
    stride = level.shape[2]
    rows = np.zeros((3, 2 * stride + 2 * LANES), np.float32)
    even, odd = np.zeros(stride + 2 * LANES, np.float32), np.zeros(stride + 2 * LANES, np.float32)
    ring = np.zeros((RING, 3, stride), np.float32)
    for y in range(2 * (first - MARGIN) - MARGIN, 2 * (last - 1 - MARGIN) + MARGIN + 1):
        if 0 <= y < height:
            for x0 in range(0, width, LANES):
                x = min(x0, width - LANES)
                c, s, weight = _weighted(tangent, magnitude, scale, certain, y * width + x)
                store(rows[0], MARGIN + x, c)
                store(rows[1], MARGIN + x, s)
                store(rows[2], MARGIN + x, weight)
            for p in range(3):
                halve_row(rows[p], MARGIN + width, even, odd, ring[y % RING, p])
        else:
            ring[y % RING] = 0
        j = (y - MARGIN) // 2 + MARGIN
        if y % 2 == 0 and j >= first:
            for p in range(3):
                smooth_rows(ring, p, y - MARGIN, level[p, j])


@kernel
def _pull_pixels(
    first: int, last: int, tangent: Array, magnitude: Array, scale: float, certain: float, width: int, level: Array
) -> None:
    """Fill the tangents of the rows ``first`` .. ``last`` - 1 in place from the first level.

    Parameters
    ----------
    tangent, magnitude
        (H, W, 2) and (H, W), flattened.
    scale
        Factor of magnitudes.
    certain
        Square of the scaled magnitude from which a tangent stays as it is; 0 fills only zero tangents.
    width
        W, at least sixteen.
    level
        Sums over all levels, at the first.
    """
    size = level.shape[2] + 2 * LANES
    smoothed, rows = np.zeros((3, size), np.float32), np.empty((3, 2 * size), np.float32)
    for y in range(first, last):
        if certain == 0 and not _any_missing(tangent, y * width, width):
            continue
        for p in range(3):
            enlarge_rows(level[p], y, smoothed[p])
            for e in range(0, (MARGIN + width + 1) // 2, LANES):
                store_pairs(rows[p], 2 * e, enlarged_row(smoothed[p], e))
        for x0 in range(0, width, LANES):
            x = min(x0, width - LANES)
            i = y * width + x
            tx, ty = load_pairs(tangent, 2 * i)
            m = load(magnitude, i) * scale
            power, length = m * m, tx * tx + ty * ty
            missing = length == 0.0
            # The last block overlaps the one before it, whose pixels are filled already.
            weak = (missing | (power < certain)) & (lane_indices() + x >= x0)
            if any_lane(weak):
                alpha = select(missing, 0.0, minimum(power / certain, 1.0))
                weight = load(rows[2], MARGIN + x)
                rest = select(weight > 0.0, (1.0 - alpha) / weight, 0.0)
                c = alpha * (tx * tx - ty * ty) + rest * load(rows[0], MARGIN + x)
                s = alpha * (2.0 * tx * ty) + rest * load(rows[1], MARGIN + x)
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
