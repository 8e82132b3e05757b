"""Quantise lightness (section 4.1), one number at a time, in float64."""

from __future__ import annotations

import math


def quantize(lstar, levels, softness=0.0):
    """Return Q of one L*."""
    size = 100 / levels
    u = lstar / size
    if softness == 0:
        return (max(1, math.ceil(u - 1e-3)) - 0.5) * size
    e = round(u)
    x = min(max((u - e) / softness + 0.5, 0), 1)
    return max((e - 0.5 + 3 * x**2 - 2 * x**3) * size, 0)


def gain(lstar, levels, softness=0.0):
    """Return the gain on scene-linear light that quantises a pixel of this L*: 1 up to L* 1, Y(Q) / Y(L*) from 8 on."""
    full = _luminance(quantize(lstar, levels, softness)) / _luminance(max(lstar, 1))
    return 1 + (full - 1) * min(max((lstar - 1) / 7, 0), 1)


def _luminance(lstar):
    """Return Y of an L*, by CIE 15:2004."""
    return ((lstar + 16) / 116) ** 3 if lstar > 8 else lstar * 27 / 24389
