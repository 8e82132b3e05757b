"""Tangents where there is little or no gradient, from the tensor average around them: push-pull by confidence.

Not in the paper, which leaves holes where the image is constant and rounding noise where it is nearly so.
A tangent t of magnitude m enters as the tensor m^2 t t^T, whose trace is the confidence W = m^2. The field is halved
down to one pixel. Then, coming up, each cell takes its own average tensor with the weight alpha = min(1, W / fill^2),
W the mean over the cell, and the coarser level's, bilinearly, with the rest. Up to its trace a tensor is its double
angle, m^2 (cos 2θ, sin 2θ).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from numba import prange

from flowabs_nodes.filters.arguments import Array
from flowabs_nodes.filters.kernels import kernel, parallel_kernel

Float64 = npt.NDArray[np.float64]

_ISOTROPIC = 1e-9  # of a trace of 1: a tensor whose double angle is shorter has no direction, only rounding


def flow_fill(tangent: Array, magnitude: Array, fill: float) -> Array:
    """Unit tangents everywhere: (H, W, 2) float32.

    Parameters
    ----------
    tangent, magnitude
        Of the gradient: (H, W, 2) unit or zero, (H, W) in code values per pixel.
    fill
        Magnitude below which a tangent leans on its surroundings, the more the weaker it is; 0 fills only zero
        tangents. Where the surroundings have no direction either, a zero tangent becomes (1, 0).
    """
    height, width = magnitude.shape
    confident = float(fill) ** 2
    # Sums over a cell's pixels rather than averages, so that the smaller cells at the far edges need no care.
    levels = [np.empty(((height + 1) // 2, (width + 1) // 2, 3))]
    _push_pixels(tangent, magnitude, levels[0])
    while levels[-1].shape[:2] != (1, 1):
        fine = levels[-1]
        levels.append(np.empty(((fine.shape[0] + 1) // 2, (fine.shape[1] + 1) // 2, 3)))
        _push(fine, levels[-1])
    c, s, weight = levels[-1][0, 0]
    axes = np.array([[[c, s]]]) / (weight if weight > 0 else 1.0)
    for level in range(len(levels) - 1, 0, -1):
        finer = np.empty((*levels[level - 1].shape[:2], 2))
        _pull(levels[level - 1], axes, confident, 2**level, height, width, finer)
        axes = finer
    filled = np.empty_like(tangent)
    _pull_pixels(tangent, magnitude, axes, confident, filled)
    return filled


@kernel
def _weighted(tangent: Array, magnitude: Array, y: int, x: int) -> tuple[float, float, float]:
    """m^2 (cos 2θ, sin 2θ) and m^2 of one pixel; all zero where it has no tangent."""
    tx, ty, m = np.float64(tangent[y, x, 0]), np.float64(tangent[y, x, 1]), np.float64(magnitude[y, x])
    weight = m * m if tx != 0 or ty != 0 else 0.0
    return weight * (tx * tx - ty * ty), weight * (2 * tx * ty), weight


@parallel_kernel
def _push_pixels(tangent: Array, magnitude: Array, sums: Float64) -> None:
    height, width = magnitude.shape
    for j in prange(sums.shape[0]):
        for i in range(sums.shape[1]):
            c, s, w = 0.0, 0.0, 0.0
            for y in range(2 * j, min(2 * j + 2, height)):
                for x in range(2 * i, min(2 * i + 2, width)):
                    dc, ds, dw = _weighted(tangent, magnitude, y, x)
                    c, s, w = c + dc, s + ds, w + dw
            sums[j, i, 0], sums[j, i, 1], sums[j, i, 2] = c, s, w


@parallel_kernel
def _push(fine: Float64, sums: Float64) -> None:
    height, width, planes = fine.shape
    for j in prange(sums.shape[0]):
        for i in range(sums.shape[1]):
            for p in range(planes):
                total = 0.0
                for y in range(2 * j, min(2 * j + 2, height)):
                    for x in range(2 * i, min(2 * i + 2, width)):
                        total += fine[y, x, p]
                sums[j, i, p] = total


@kernel
def _bilinear(axes: Float64, y: int, x: int) -> tuple[float, float]:
    """The coarser level at the centre of finer cell (y, x): cell j covers the finer cells 2j and 2j + 1."""
    j0, i0 = y // 2, x // 2
    j1 = min(max(j0 + 2 * (y % 2) - 1, 0), axes.shape[0] - 1)
    i1 = min(max(i0 + 2 * (x % 2) - 1, 0), axes.shape[1] - 1)
    c = 9 * axes[j0, i0, 0] + 3 * (axes[j0, i1, 0] + axes[j1, i0, 0]) + axes[j1, i1, 0]
    s = 9 * axes[j0, i0, 1] + 3 * (axes[j0, i1, 1] + axes[j1, i0, 1]) + axes[j1, i1, 1]
    return c / 16, s / 16


@kernel
def _lean(c: float, s: float, weight: float, confident: float, below_c: float, below_s: float) -> tuple[float, float]:
    """alpha (c, s) / weight + (1 - alpha) below, alpha = min(1, weight / confident), and 0 where the weight is 0."""
    if weight == 0:
        return below_c, below_s
    whole = max(weight, confident)
    rest = 1 - weight / whole
    return c / whole + rest * below_c, s / whole + rest * below_s


@parallel_kernel
def _pull(sums: Float64, coarser: Float64, confident: float, size: int, height: int, width: int, axes: Float64) -> None:
    for j in prange(axes.shape[0]):
        rows = min(size, height - j * size)
        for i in range(axes.shape[1]):
            area = rows * min(size, width - i * size)
            below_c, below_s = _bilinear(coarser, j, i)
            axes[j, i, 0], axes[j, i, 1] = _lean(
                sums[j, i, 0], sums[j, i, 1], sums[j, i, 2], confident * area, below_c, below_s
            )


@parallel_kernel
def _pull_pixels(tangent: Array, magnitude: Array, coarser: Float64, confident: float, filled: Array) -> None:
    for y in prange(magnitude.shape[0]):
        for x in range(magnitude.shape[1]):
            c, s, weight = _weighted(tangent, magnitude, y, x)
            tx, ty = float(tangent[y, x, 0]), float(tangent[y, x, 1])
            if weight < confident or weight == 0:
                below_c, below_s = _bilinear(coarser, y, x)
                c, s = _lean(c, s, weight, confident, below_c, below_s)
                if c * c + s * s > _ISOTROPIC**2:
                    tx, ty = half_angle(c, s)
                elif weight == 0:
                    tx, ty = 1.0, 0.0
            filled[y, x, 0], filled[y, x, 1] = tx, ty


@kernel
def half_angle(c: float, s: float) -> tuple[float, float]:
    """The unit vector at half the angle of (c, s), so the major eigenvector of [[c, s], [s, -c]]; zero for zero."""
    r = np.sqrt(c * c + s * s)
    large = np.sqrt((r + abs(c)) / 2)
    inverse = 0.0 if r == 0 else 1 / large
    small = s / 2 * inverse
    norm = 0.0 if r == 0 else 1 / np.sqrt(r)
    x = large if c >= 0 else small
    y = small if c >= 0 else large
    return x * norm, y * norm
