"""Smooth with the flow-based bilateral filter (section 4.1), in float64."""

from __future__ import annotations

import numpy as np

from tests.naive.walk import READ, curve


def fbl(codes, flow, sigma_e, r_e, sigma_g, r_g, iterations, sampling="nearest", alpha=None):
    """Smooth codes (H, W, 3) by eqs. 12 to 14; every sample's weight, also the centre's, is multiplied by its alpha."""
    codes, flow = np.asarray(codes, np.float64), np.asarray(flow, np.float64)
    alpha = np.ones(codes.shape[:2]) if alpha is None else np.asarray(alpha, np.float64)
    for _ in range(iterations):
        steps = int(np.ceil(3 * sigma_e))
        path = [(s, dx, dy) for way in (1, -1) for s, (dx, dy, _) in enumerate(curve(flow, steps, way), 1)]
        codes = _bilateral(codes, alpha, path, sigma_e, r_e, sampling)  # eq. 12
        steps = int(np.ceil(3 * sigma_g))
        path = [(n, n * flow[..., 1], -n * flow[..., 0]) for n in range(-steps, steps + 1) if n != 0]
        codes = _bilateral(codes, alpha, path, sigma_g, r_g, sampling)  # eq. 14
    return codes


def _bilateral(codes, alpha, path, sigma, r, sampling):
    """Return the weighted mean of the centre and of samples s steps along, (dx, dy) away: (s, dx, dy) in ``path``."""
    read = READ[sampling]
    total, weight = alpha[..., None] * codes, alpha.copy()
    for s, dx, dy in path:
        there = read(alpha, dx, dy)
        colour = read(alpha[..., None] * codes, dx, dy) / np.where(there > 0, there, 1)[..., None]
        distance = np.linalg.norm(colour - codes, axis=-1)
        h = np.exp(-(distance**2) / (2 * r**2))  # eq. 13
        w = there * np.exp(-(s**2) / (2 * sigma**2)) * h
        total, weight = total + w[..., None] * colour, weight + w
    return np.where(alpha[..., None] > 0, total / np.where(weight > 0, weight, 1)[..., None], codes)
