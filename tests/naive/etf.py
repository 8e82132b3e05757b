"""The edge tangent flow of section 2, neighbour by neighbour, in float64."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tests.naive.fill import flow_fill

Float64 = npt.NDArray[np.float64]


def gradient(code: npt.ArrayLike) -> tuple[Float64, Float64]:
    """Return tangents (H, W, 2), zero where there is no gradient, and |g| (H, W): Sobel / 8, the border repeated.

    Of several channels (H, W, C), g is the major eigenvector of sum_k g_k g_k^T, |g| the root of its eigenvalue.
    """
    code = np.asarray(code, np.float64)
    height, width = code.shape[:2]
    padded = np.pad(code.reshape(height, width, -1), ((1, 1), (1, 1), (0, 0)), "edge")
    sobel = np.array([[-1, 0, 1], [-2, 0, 2], [-1, 0, 1]]) / 8
    tangent, magnitude = np.zeros((height, width, 2)), np.zeros((height, width))
    for y in range(height):
        for x in range(width):
            around = padded[y : y + 3, x : x + 3]
            g = np.array([np.tensordot(sobel, around), np.tensordot(sobel.T, around)])  # (2, channels)
            values, vectors = np.linalg.eigh(g @ g.T)
            magnitude[y, x] = np.sqrt(max(values[1], 0))
            if magnitude[y, x] > 0:
                gx, gy = vectors[:, 1]
                tangent[y, x] = -gy, gx
    return tangent, magnitude


def etf(
    code: npt.ArrayLike,
    radius: float,
    iterations: int,
    kernel: str = "full",
    reference: float | None = None,
    fill: float | None = None,
    mask: npt.ArrayLike | None = None,
    edges: tuple[npt.ArrayLike, npt.ArrayLike, float] | None = None,
) -> Float64:
    """Return the ETF by eqs. 1-5 as printed; pixels outside the picture take no part.

    ``reference`` is the gradient of full strength, None its maximum; with ``fill`` None tangents may be zero. A pixel's
    gradient, certainty and weight are multiplied by ``mask``; where it is 0 there is no tangent. ``edges`` are the
    strength, the tangents and the weight of edges that are known.
    """
    tangent, magnitude = gradient(code)
    if edges is not None:
        tangent, magnitude = with_edges(tangent, magnitude, *edges)
    mask = np.ones(magnitude.shape) if mask is None else np.asarray(mask, np.float64)
    tangent, magnitude = np.where(mask[..., None] > 0, tangent, 0), magnitude * mask
    reference = magnitude.max() if reference is None else reference
    strength = np.minimum(magnitude / reference, 1) if reference > 0 else np.zeros_like(magnitude)
    if fill is not None:
        tangent = flow_fill(tangent, magnitude, fill, mask)
    d = range(-int(np.ceil(radius)), int(np.ceil(radius)) + 1)
    disc = [(dx, dy) for dy in d for dx in d if dx * dx + dy * dy < radius * radius]  # eq. 2
    row, column = [(k, 0) for k in d if abs(k) < radius], [(0, k) for k in d if abs(k) < radius]
    for _ in range(iterations):
        for offsets in [disc] if kernel == "full" else [row, column]:
            tangent = _smooth(tangent, strength, offsets, mask)
    return tangent


def with_edges(
    tangent: Float64, magnitude: Float64, strength: npt.ArrayLike, flow: npt.ArrayLike, weight: float
) -> tuple[Float64, Float64]:
    """Return tangents and magnitudes of g g^T + e e^T, pixel by pixel."""
    tangent, magnitude = tangent.copy(), magnitude.copy()
    strength, flow = np.asarray(strength, np.float64), np.asarray(flow, np.float64)
    for y, x in np.argwhere(strength > 0):
        g = magnitude[y, x] * np.array([tangent[y, x, 1], -tangent[y, x, 0]])
        e = weight * strength[y, x] * np.array([flow[y, x, 1], -flow[y, x, 0]])
        values, vectors = np.linalg.eigh(np.outer(g, g) + np.outer(e, e))
        magnitude[y, x] = np.sqrt(values[1])
        if values[1] > values[0]:
            tangent[y, x] = -vectors[1, 1], vectors[0, 1]
    return tangent, magnitude


def _smooth(
    tangent: Float64, strength: Float64, offsets: list[tuple[int, int]], mask: Float64 | None = None
) -> Float64:
    """Return the tangents after one application of eq. 1, summed over the pixels at ``offsets`` (dx, dy)."""
    mask = np.ones_like(strength) if mask is None else mask
    height, width = strength.shape
    total = np.zeros_like(tangent)
    for dx, dy in offsets:  # y = x + (dx, dy), for all x whose y lies in the picture
        here = np.s_[max(-dy, 0) : max(height - max(dy, 0), 0), max(-dx, 0) : max(width - max(dx, 0), 0)]
        there = np.s_[max(dy, 0) : max(height + min(dy, 0), 0), max(dx, 0) : max(width + min(dx, 0), 0)]
        dot = (tangent[here] * tangent[there]).sum(-1)
        phi = np.where(dot > 0, 1, -1)  # eq. 5
        w_m = (strength[there] - strength[here] + 1) / 2  # eq. 3
        w_d = np.abs(dot)  # eq. 4
        total[here] += (mask[there] * phi * w_m * w_d)[..., None] * tangent[there]  # eq. 1
    k = np.linalg.norm(total, axis=-1, keepdims=True)
    return np.where(k > 0, total / np.where(k > 0, k, 1), tangent)


def degrees_between(flow: npt.ArrayLike, other: npt.ArrayLike) -> Float64:
    """Return the angle between orientations in degrees, 0 to 90; a tangent of zero agrees with any."""
    a, b = np.asarray(flow, np.float64), np.asarray(other, np.float64)
    cross = np.abs(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
    dot = np.abs((a * b).sum(-1))
    return np.degrees(np.arctan2(cross, dot))
