"""Passes of small scenes, drawn by formulas."""

from __future__ import annotations

import numpy as np

HEIGHT, WIDTH = 40, 56


def grid(height=HEIGHT, width=WIDTH):
    """Return y and x of the pixels."""
    y, x = np.mgrid[:height, :width].astype(np.float64)
    return y, x


def wall(height=HEIGHT, width=WIDTH):
    """Return the depth of a wall that runs away to the right, as a plane does in perspective."""
    y, x = grid(height, width)
    return 1 / (0.1 - 0.0008 * x + 0.0003 * y)


def disc(height=HEIGHT, width=WIDTH, radius=11.0, center=(18.3, 24.7)):
    """Return where a disc is."""
    y, x = grid(height, width)
    return (y - center[0]) ** 2 + (x - center[1]) ** 2 < radius**2


def disc_before_wall(height=HEIGHT, width=WIDTH):
    """Return depth and ids of a tilted disc, id 7, before a wall, id 3."""
    y, x = grid(height, width)
    there = disc(height, width)
    depth = np.where(there, 1 / (0.2 + 0.001 * y - 0.0007 * x), wall(height, width))
    return depth.astype(np.float32), np.where(there, 7, 3).astype(np.uint32)


def floor_to_horizon(scale=1.0, height=60, width=32):
    """Return the depth of a floor up to the horizon, Inf above it."""
    y, _ = grid(height, width)
    below = y - 19.4
    return np.where(below > 0, scale * 400 / np.maximum(below, 1e-9), np.inf)


def roof(angle, height=HEIGHT, width=WIDTH, slope=0.3):
    """Return normals of two flat faces that meet at ``angle`` degrees along a slanted line, and its distance."""
    y, x = grid(height, width)
    d = (x - 28.2 - slope * (y - 20)) / np.hypot(1, slope)
    half = np.radians(angle) / 2
    turn = np.where(d < 0, -half, half)
    return np.stack([np.sin(turn), 0 * turn, np.cos(turn)], axis=2).astype(np.float32), d
