"""Draw the picture to measure on: like a photograph, and the same on every machine."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float32]

CELLS = (4, 16, 64)  # sizes of the shapes, in pixels, whatever the size of the picture


def scene(width: int, height: int) -> Array:
    """Draw scene-linear RGB, (height, width, 3): shading, edges of every direction, texture, grain, highlights."""
    random = np.random.default_rng(2009)
    rgb = np.empty((height, width, 3), np.float32)
    shared = _shapes(random, height, width)  # most edges are in all channels at once
    for channel in range(3):
        shapes = shared + np.float32(0.3) * _shapes(random, height, width)
        lit = np.where(np.sin(12 * shapes) > 0, shapes, np.float32(0.4) * shapes)
        grain = random.standard_normal((height, width), np.float32)
        rgb[..., channel] = np.clip(0.4 + lit + 0.02 * grain, 0.001, 1.5)
    return rgb


def _shapes(random: np.random.Generator, height: int, width: int) -> Array:
    """Return noise of several sizes, the larger the stronger."""
    total = np.zeros((height, width), np.float32)
    for cell in CELLS:
        corners = random.standard_normal((height // cell + 2, width // cell + 2), np.float32)
        total += np.float32(0.05 * cell**0.5) * _between(_between(corners, height, cell).T, width, cell).T
    return total


def _between(corners: Array, count: int, cell: int) -> Array:
    """Return ``count`` rows, interpolated smoothly between the rows of ``corners``, ``cell`` rows apart."""
    place = np.arange(count, dtype=np.float32)[:, np.newaxis] / np.float32(cell)
    first = place[:, 0].astype(np.intp)
    t = place - np.floor(place)
    t = t * t * (3 - 2 * t)
    return np.asarray(corners[first] * (1 - t) + corners[first + 1] * t, np.float32)
