"""Quantise lightness (section 4.1), one number at a time, in float64."""

from __future__ import annotations

import math

import numpy as np


def quantize(lstar, levels, softness=0.0, phase=0.0):
    """Return Q of one L*."""
    size = 100 / levels
    u = lstar / size
    if softness == 0:
        lowest = phase / 2 if phase > 0 else 0.5
        return max(math.ceil(u - phase - 1e-3) - 0.5 + phase, lowest) * size
    e = round(u - phase)
    x = min(max((u - phase - e) / softness + 0.5, 0), 1)
    return max(e - 0.5 + phase + 3 * x**2 - 2 * x**3, phase / 2) * size


def by_gradient(lstar, rise, levels, softness=0.0, phase=0.0, amount=1.0, hard=5.0):
    """Return what becomes of one L* of that rise."""
    x = min(rise / hard, 1)
    h = 3 * x**2 - 2 * x**3
    width = min(max(rise / (100 / levels), 1 - h), 1)
    q = quantize(lstar, levels, softness + amount * (width - softness), phase)
    return lstar + (q - lstar) * (1 - 0.55 * amount * (1 - h))


def rises(lstar, sigma):
    """Return sigma |grad(G_sigma * L*)| of a picture: Gaussian weights to ceil(3 sigma), then Sobel / 8."""
    height, width = lstar.shape
    reach = math.ceil(3 * sigma)
    weights = {k: math.exp(-(k * k) / (2 * sigma * sigma)) for k in range(-reach, reach + 1)}
    total = sum(weights.values()) ** 2

    def at(picture, y, x):
        return float(picture[min(max(y, 0), height - 1), min(max(x, 0), width - 1)])

    blurred = np.empty((height, width))
    for y in range(height):
        for x in range(width):
            every = (weights[v] * weights[u] * at(lstar, y + v, x + u) for v in weights for u in weights)
            blurred[y, x] = sum(every) / total
    result = np.empty((height, width))
    for y in range(height):
        for x in range(width):
            gx, gy = 0.0, 0.0
            for k, weight in ((-1, 1), (0, 2), (1, 1)):
                gx += weight * (at(blurred, y + k, x + 1) - at(blurred, y + k, x - 1)) / 8
                gy += weight * (at(blurred, y + 1, x + k) - at(blurred, y - 1, x + k)) / 8
            result[y, x] = sigma * math.hypot(gx, gy)
    return result


def gain(lstar, levels, softness=0.0, phase=0.0):
    """Return the gain on scene-linear light that quantises a pixel of this L*: 1 up to L* 1, Y(Q) / Y(L*) from 8 on."""
    full = _luminance(quantize(lstar, levels, softness, phase)) / _luminance(max(lstar, 1))
    return 1 + (full - 1) * min(max((lstar - 1) / 7, 0), 1)


def _luminance(lstar):
    """Return Y of an L*, by CIE 15:2004."""
    return ((lstar + 16) / 116) ** 3 if lstar > 8 else lstar * 27 / 24389
