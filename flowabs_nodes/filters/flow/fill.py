"""Fill tangents where there is little or no gradient from the tensor average around them: a normalised convolution.

The paper leaves holes where the image is constant, and rounding noise where it is nearly so. Here a tangent t of
magnitude m has the *certainty* alpha = min(1, m^2 / fill^2) and counts as the tensor W t t^T of weight W = alpha m^2.
With (c, s) = W (cos 2θ, sin 2θ), θ the angle of t, the tensor average around a pixel is

    (c', s') = sum_y K(x - y) (c, s)(y) / sum_y K(x - y) W(y)

(normalised convolution, Knutsson and Westin 1993). The filled tangent is at half the angle of alpha (cos 2θ, sin 2θ) +
(1 - alpha) (c', s'). K is a sum of Gaussians of growing scale, the finest of sigma 1.2, each twice as wide as the one
before and of half its weight. So K falls off as distance^-3: near tangents count most, far ones count where nothing is
near, and the direction changes smoothly. The sums do not depend on where the pixel grid lies (``gaussian_pyramid.py``).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters.flow.gaussian_pyramid import (
    DECAY,
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
from flowabs_nodes.simd.lanes import LANES, Floats, any_lane, minimum, select, splat_floats
from flowabs_nodes.simd.memory import load, load_pairs, store, store_pairs

_A0, _A1, _A2, _A3 = (math.comb(6, 3 + j) / 2**6 for j in range(4))  # the finest scale: a binomial filter of sigma 1.2
_ISOTROPIC = 1e-6  # a tensor of trace 1 whose double angle is shorter than this has no direction, only rounding


def flow_fill(
    tangent: Array, magnitude: Array, fill: float, largest: float | None = None, mask: Array | None = None
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
    mask
        (H, W), 0 to 1, what the certainty of each pixel is multiplied by; None is 1 everywhere.

    Returns
    -------
    (H, W, 2) float32 unit vectors.
    """
    largest = float(magnitude.max()) if largest is None else largest
    beside = max(0, LANES - magnitude.shape[1])  # columns of zeros, which count as little as what lies outside
    if beside:
        tangent, magnitude = np.pad(tangent, [(0, 0), (0, beside), (0, 0)]), np.pad(magnitude, [(0, 0), (0, beside)])
        mask = None if mask is None else np.pad(mask, [(0, 0), (0, beside)])
    height, width = magnitude.shape
    # Scaled magnitudes are below 1, so no weight overflows; 2^-63 of the largest magnitude or less counts as none.
    scale = math.ldexp(1, min(-math.frexp(largest)[1], 126))
    weights = np.empty(0, np.float32) if mask is None else mask.reshape(-1)
    pixels = Pixels(tangent.reshape(-1), magnitude.reshape(-1), weights, scale, height, width)
    certain = np.float32(min(fill * scale, 1e18) ** 2)
    level, filled = first_level(3, height, width), np.empty_like(tangent)
    over_rows(_push_pixels, level.shape[1], pixels, certain, level, least=32)
    sum_over_scales(level, height, width)
    over_rows(_pull_pixels, height, pixels, certain, level, filled.reshape(-1))
    return np.ascontiguousarray(filled[:, : width - beside])


class Pixels(NamedTuple):
    """The gradient of a picture at least sixteen pixels wide."""

    tangent: Array  # (H, W, 2), flattened
    magnitude: Array  # (H, W), flattened
    mask: Array  # (H, W), flattened: what certainties are multiplied by; empty where that is 1
    scale: float  # factor of magnitudes
    height: int
    width: int


@inlined
def _inverse(certain: float) -> float:
    """Return 1 / ``certain``, or 2^126 where ``certain`` is smaller than that allows."""
    return 1.0 / max(certain, 2.0**-126)


@inlined
def _weigh_row(
    tangent: Array, magnitude: Array, mask: Array, scale: float, certain: float, first: int, width: int, weighed: Array
) -> None:
    """Write c, s and W of the row that begins with pixel ``first`` into three rows, from position MARGIN on.

    ``certain`` is fill^2 in the scale of ``scale``. Zero tangents have no weight.
    """
    # Weights are only compared with each other, so they need not become as small as the certainties of a huge fill.
    inverse = _inverse(min(certain, np.float32(1.0)))
    for x0 in range(0, width, LANES):
        x = min(x0, width - LANES)
        tx, ty = load_pairs(tangent, 2 * (first + x))
        m = load(magnitude, first + x) * scale
        xx, yy, power = tx * tx, ty * ty, m * m
        weight = select(xx + yy > 0.0, power * minimum(power * inverse, 1.0), 0.0)
        if mask.size > 0:
            weight = weight * load(mask, first + x)
        store(weighed[0], MARGIN + x, weight * (xx - yy))
        store(weighed[1], MARGIN + x, weight * (2.0 * tx * ty))
        store(weighed[2], MARGIN + x, weight)


@kernel
def _push_pixels(first: int, last: int, pixels: Pixels, certain: float, level: Array) -> None:
    """Write the rows ``first`` .. ``last`` - 1 of the first level; ``certain`` is fill^2 in the scale of ``pixels``."""
    tangent, magnitude, mask, scale, height, width = pixels
    stride = level.shape[2]
    weighed = np.zeros((3, 2 * stride + 2 * LANES), np.float32)
    even, odd = np.zeros(stride + 2 * LANES, np.float32), np.zeros(stride + 2 * LANES, np.float32)
    ring = np.zeros((RING, 3, stride), np.float32)
    for y in range(2 * (first - MARGIN) - MARGIN, 2 * (last - 1 - MARGIN) + MARGIN + 1):
        if 0 <= y < height:
            _weigh_row(tangent, magnitude, mask, scale, certain, y * width, width, weighed)
            for p in range(3):
                halve_row(weighed[p], MARGIN + width, even, odd, ring[y % RING, p])
        else:
            ring[y % RING] = 0
        j = (y - MARGIN) // 2 + MARGIN
        if y % 2 == 0 and j >= first:
            for p in range(3):
                smooth_rows(ring, p, y - MARGIN, level[p, j])


@kernel
def _pull_pixels(first: int, last: int, pixels: Pixels, certain: float, level: Array, filled: Array) -> None:
    """Write the rows ``first`` .. ``last`` - 1 of the filled tangents, (H, W, 2) flattened.

    ``certain`` is the square of the scaled magnitude from which a tangent stays as it is; 0 fills only zero tangents.
    ``level`` holds the sums over all but the finest scale.
    """
    tangent, magnitude, mask, scale, height, width = pixels
    inverse, size = _inverse(certain), level.shape[2] + 2 * LANES
    smoothed, coarse = np.zeros(size, np.float32), np.empty((3, 2 * size), np.float32)
    weighed = np.zeros((3, 2 * size), np.float32)
    ring = np.zeros((8, 3, 2 * size), np.float32)
    ready = first - 3  # the first row that is not in the ring yet
    for y in range(first, last):
        if certain == 0 and mask.size == 0 and not _any_missing(tangent, y * width, width):
            filled[2 * y * width : 2 * (y + 1) * width] = tangent[2 * y * width : 2 * (y + 1) * width]
            continue
        for row in range(max(ready, y - 3), y + 4):
            if 0 <= row < height:
                _weigh_row(tangent, magnitude, mask, scale, certain, row * width, width, weighed)
                for p in range(3):
                    _smooth_row(weighed[p], width, ring[row % 8, p])
            else:
                ring[row % 8] = 0
        ready = y + 4
        for p in range(3):
            enlarge_rows(level[p], y, smoothed)
            for e in range(0, (MARGIN + width + 1) // 2, LANES):
                store_pairs(coarse[p], 2 * e, enlarged_row(smoothed, e))
        for x0 in range(0, width, LANES):
            x = min(x0, width - LANES)
            i = y * width + x
            tx, ty = load_pairs(tangent, 2 * i)
            m = load(magnitude, i) * scale
            power = m * m
            missing, sure = tx * tx + ty * ty == 0.0, splat_floats(1.0)
            if mask.size > 0:
                sure = load(mask, i)
            weak = missing | (power < certain) | (sure < 1.0)
            if any_lane(weak):
                alpha = select(missing, 0.0, minimum(power * inverse, 1.0) * sure)
                weight = _finest(ring, 2, y, x) + DECAY * load(coarse[2], MARGIN + x)
                rest = select(weight > 0.0, (1.0 - alpha) / weight, 0.0)
                c = _finest(ring, 0, y, x) + DECAY * load(coarse[0], MARGIN + x)
                s = _finest(ring, 1, y, x) + DECAY * load(coarse[1], MARGIN + x)
                c, s = alpha * (tx * tx - ty * ty) + rest * c, alpha * (2.0 * tx * ty) + rest * s
                new_x, new_y = half_angle(c, s)
                directed = weak & (c * c + s * s > _ISOTROPIC**2)
                tx = select(directed, new_x, select(missing, 1.0, tx))
                ty = select(directed, new_y, ty)
            store_pairs(filled, 2 * i, (tx, ty))


@inlined
def _smooth_row(weighed: Array, width: int, smoothed: Array) -> None:
    """Smooth a row, which begins at position MARGIN, along x at the finest scale."""
    for x in range(0, width, LANES):
        i = MARGIN + x
        total = _A3 * (load(weighed, i - 3) + load(weighed, i + 3)) + _A2 * (
            load(weighed, i - 2) + load(weighed, i + 2)
        )
        total = total + _A1 * (load(weighed, i - 1) + load(weighed, i + 1))
        store(smoothed, x, total + _A0 * load(weighed, i))


@inlined
def _finest(ring: Array, p: int, y: int, x: int) -> Floats:
    """Return plane p of sixteen pixels, smoothed at the finest scale: along y, rows of the ring along x already."""
    total = _A3 * (load(ring[(y - 3) % 8, p], x) + load(ring[(y + 3) % 8, p], x))
    total = total + _A2 * (load(ring[(y - 2) % 8, p], x) + load(ring[(y + 2) % 8, p], x))
    total = total + _A1 * (load(ring[(y - 1) % 8, p], x) + load(ring[(y + 1) % 8, p], x))
    return total + _A0 * load(ring[y % 8, p], x)


@inlined
def _any_missing(tangent: Array, first: int, width: int) -> bool:
    """Return whether the row of ``width`` pixels that begins with pixel ``first`` has a zero tangent."""
    for x0 in range(0, width, LANES):
        tx, ty = load_pairs(tangent, 2 * (first + min(x0, width - LANES)))
        if any_lane(tx * tx + ty * ty == 0.0):
            return True
    return False
