"""Lines displaced by a field of chance, in float64; the field is the one that is tested."""

from __future__ import annotations

import numpy as np

from flowabs_nodes.filters.motion.smooth_noise import smooth_noise
from tests.naive.fdog import blur


def vectors(shape, origin, size, seed, number):
    """Return the field's vectors, (H, W, 2)."""
    field = smooth_noise(shape, origin, size, seed, number)
    lattice = field.vectors.astype(np.float64)
    j, i = field.rows[:, None], field.columns[None, :]
    v, u = field.down.astype(np.float64)[:, None], field.across.astype(np.float64)[None, :]
    above = (1 - v) * lattice[:, j, i] + v * lattice[:, j + 1, i]
    below = (1 - v) * lattice[:, j, i + 1] + v * lattice[:, j + 1, i + 1]
    return np.moveaxis((1 - u) * above + u * below, 0, -1)


def boil(lines, flow, amount, hold, size, seed, frame, origin=(0, 0)):
    """Return the displaced drawing."""
    lines, flow = lines.astype(np.float64), flow.astype(np.float64)
    height, width = lines.shape
    v = vectors(lines.shape, origin, size, seed, (frame - 1) // hold)
    c, s = blur(flow[..., 0] ** 2 - flow[..., 1] ** 2, 2.0), blur(2 * flow[..., 0] * flow[..., 1], 2.0)
    tensor = np.stack([np.stack([1 + c, s], -1), np.stack([s, 1 - c], -1)], -2) / 2
    d = amount * (v - (tensor @ v[..., None])[..., 0])
    y, x = np.indices(lines.shape)
    left, top = np.floor(d[..., 0]).astype(int), np.floor(d[..., 1]).astype(int)
    ink = np.zeros(lines.shape)
    for j in range(-1, 3):
        for i in range(-1, 3):
            weight = catmull_rom(j - (d[..., 1] - top)) * catmull_rom(i - (d[..., 0] - left))
            ink += weight * lines[np.clip(y + top + j, 0, height - 1), np.clip(x + left + i, 0, width - 1)]
    return np.clip(ink, 0, 1)


def catmull_rom(t):
    """Return the kernel of R. Keys with a = -1/2."""
    t = np.abs(t)
    near, far = 1.5 * t**3 - 2.5 * t**2 + 1, -0.5 * t**3 + 2.5 * t**2 - 4 * t + 2
    return np.where(t <= 1, near, np.where(t < 2, far, 0))
