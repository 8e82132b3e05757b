"""Remove what is smaller than a scale by the rolling guidance filter (Zhang et al. 2014), in float64."""

from __future__ import annotations

import numpy as np


def rolling_guidance(codes, sigma_s, sigma_r, iterations, alpha=None):
    """Blur codes (H, W, 3), then average the codes again and again among pixels that are alike in the last result."""
    codes = np.asarray(codes, np.float64)
    alpha = np.ones(codes.shape[:2]) if alpha is None else np.asarray(alpha, np.float64)
    guide = _joint(codes, np.zeros_like(codes), sigma_s, 1, alpha)  # J_0: all are alike
    for _ in range(iterations):
        guide = _joint(codes, guide, sigma_s, sigma_r, alpha)
    return np.where(alpha[..., None] > 0, guide, codes)


def _joint(codes, guide, sigma_s, sigma_r, alpha):
    """Return the mean of columns, then rows, of ``codes`` among pixels alike in ``guide``; the border is repeated."""
    steps = int(np.ceil(3 * sigma_s))
    for axis in (0, 1):
        places = np.arange(codes.shape[axis])
        total, weight = np.zeros_like(codes), np.zeros_like(alpha)
        for s in range(-steps, steps + 1):
            there = np.clip(places + s, 0, places[-1])
            near = np.exp(-(s**2) / (2 * sigma_s**2))
            alike = np.exp(-((guide - np.take(guide, there, axis)) ** 2).sum(-1) / (2 * sigma_r**2))
            w = np.take(alpha, there, axis) * near * alike
            total, weight = total + w[..., None] * np.take(codes, there, axis), weight + w
        codes = np.where(alpha[..., None] > 0, total / np.where(weight > 0, weight, 1)[..., None], 0)
    return codes
