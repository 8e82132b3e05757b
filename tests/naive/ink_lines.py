"""Lines from distances and mattes, in float64."""

from __future__ import annotations

import numpy as np

from flowabs_nodes.filters.passes.pens import PENS
from tests.naive.streamline import bilinear, nearest


def ink_lines(distance, mattes, pens, depth=None, width_by_depth=0.0, reference_depth=10.0):
    """Return the ink, (H, W, 4)."""
    d = distance.astype(np.float64)
    nx, ny = slope(d, 1), slope(d, 0)
    steep = np.hypot(nx, ny)
    nx, ny = (np.where(steep > 0, each / np.where(steep > 0, steep, 1), 0) for each in (nx, ny))
    wider = np.ones(d.shape)
    if width_by_depth > 0:
        there = np.where(np.isnan(depth), np.inf, depth.astype(np.float64))
        z = np.min([nearest(there, (k - d) * nx, (k - d) * ny) for k in (-0.25, 0.75, 1.75)], axis=0)
        wider = np.where(z < 1e9, (reference_depth / np.maximum(z, 1e-6)) ** width_by_depth, 1)
    rest, ink = np.ones(d.shape), np.zeros((*d.shape, 4))
    for kind, pen in PENS.items():
        pen = pens.get(kind, pen)
        if kind not in mattes:
            continue
        w = np.minimum(pen.width * wider, 8)
        half = np.where(d > -0.5, w / 2 - np.abs(d), -1) if kind == "crease" else np.minimum(d, w - d)
        line = np.clip(half + 0.5, 0, np.minimum(w, 1))
        ways = (-1, 0, 1) if kind == "crease" else (-0.25, 0.75, 1.75)
        held = sum(bilinear(mattes[kind].astype(np.float64), (k - d) * nx, (k - d) * ny) for k in ways)
        presence = np.where(line > 0, np.minimum(held, rest), 0)
        rest = rest - presence
        ink += (presence * line)[..., None] * pen.opacity * np.array([*pen.color, 1])
    return ink


def slope(d, axis):
    """Return the slope along an axis: of both sides, but for one where the distance jumps."""
    padded = np.pad(d, [(1, 1) if each == axis else (0, 0) for each in (0, 1)], "edge")
    steps = np.diff(padded, axis=axis)
    before, after = (np.delete(steps, end, axis) for end in (-1, 0))
    flat = [np.abs(each) < 1.25 for each in (before, after)]
    total = np.where(flat[0], before, 0) + np.where(flat[1], after, 0)
    return total / np.maximum(flat[0].astype(int) + flat[1], 1)
