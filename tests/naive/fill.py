"""The fill of weak tangents by normalised convolution, as matrices that smooth one axis, in float64."""

from __future__ import annotations

from math import comb

import numpy as np
import numpy.typing as npt

Float64 = npt.NDArray[np.float64]


def flow_fill(tangent: Float64, magnitude: Float64, fill: float, mask: Float64 | None = None) -> Float64:
    """Return the major eigenvectors of tensors that lean on the average around them, the more the weaker they are.

    Tangents of a magnitude of ``fill`` or more stay as they are, where ``mask`` is 1: it multiplies their certainty.
    """
    mask = np.ones_like(magnitude) if mask is None else mask
    height, width = magnitude.shape
    present = tangent.any(-1)
    alpha = np.minimum(1, (magnitude / fill) ** 2) if fill > 0 else np.ones((height, width))
    alpha = np.where(present, alpha * mask, 0)
    weight = magnitude**2 * alpha
    own = tangent[..., :, None] * tangent[..., None, :]
    sums, weights = np.zeros((height, width, 2, 2)), np.zeros((height, width))
    levels = range(max(1, int(np.ceil(np.log2(max(height, width) / 2)))) + 1)
    for k in levels:
        along_y, along_x = smoothing(height, k), smoothing(width, k)
        sums += 0.5**k * np.einsum("yj,jiab,xi->yxab", along_y, weight[..., None, None] * own, along_x, optimize=True)
        weights += 0.5**k * along_y @ weight @ along_x.T
    filled = tangent.copy()
    for y, x in np.argwhere(alpha < 1):
        around = sums[y, x] / weights[y, x] if weights[y, x] > 0 else np.zeros((2, 2))
        values, vectors = np.linalg.eigh(alpha[y, x] * own[y, x] + (1 - alpha[y, x]) * around)
        if values[1] - values[0] > 1e-6:
            filled[y, x] = vectors[:, 1]
        elif not present[y, x]:
            filled[y, x] = 1, 0
    return filled


def smoothing(size: int, level: int) -> Float64:
    """Return the matrix that smooths an axis of ``size`` pixels, nearly by a Gaussian of sigma 1.2 to 1.4 * 2^level.

    It goes to samples of every 2^level-th pixel, and back by the same filter. Level 0 is a binomial filter of the same
    kind. Rows sum to 1 far from the ends.
    """
    if level == 0:
        return np.array([[_binomial(6, x - y) for y in range(size)] for x in range(size)])
    down, at = np.eye(size), np.arange(size)  # row i of ``down`` is the sample at position at[i], in its level's steps
    for _ in range(level):
        coarse = np.arange((at[0] - 6) // 2, (at[-1] + 6) // 2 + 1)
        down = np.array([[_binomial(12, j - 2 * i) for j in at] for i in coarse]) @ down
        at = coarse
    return 2**level * down.T @ down


def _binomial(order: int, offset: int) -> float:
    """Return the weight of the sample at ``offset`` in the binomial filter of an even order."""
    return comb(order, order // 2 + offset) / 2**order if abs(offset) <= order // 2 else 0.0
