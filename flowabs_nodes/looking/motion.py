"""Look at motion: its direction as colour, its length as how strong the colour is."""

from __future__ import annotations

import numpy as np

from flowabs_nodes.image import Image
from flowabs_nodes.looking.look import Look
from flowabs_nodes.looking.stretch import finite_range

#: A few pixels may be much faster than all others.
_PERCENTILE = 99.0


def look_at_motion(image: Image) -> Look:
    """Return a hue for each direction in which things move, stronger the faster; grey where nothing moves.

    A movement at angle θ (x right, y up) of length m becomes ½ + ½ m cos(θ - φ) with φ = 0°, 120°, 240° for R, G, B.
    It is the one since the previous frame, or where a pass has none of it the one to the next frame.
    """
    since, to = -image.pixels[..., :2], -image.pixels[..., 2:]
    which, moved = ("since the previous frame", since) if np.any(since) else ("to the next frame", to)
    moved = np.nan_to_num(moved, nan=0.0, posinf=0.0, neginf=0.0).astype(np.float64)
    length = np.hypot(moved[..., 0], moved[..., 1])
    moving = length[length > 0]
    if not moving.size:
        return Look(np.full((*length.shape, 3), 0.5, np.float32), "motion: nothing moves")
    _, scale = finite_range(moving, (0, _PERCENTILE))
    moved *= (np.minimum(length, scale) / np.where(length > 0, length, 1) / scale)[..., None]
    angles = np.deg2rad([0.0, 120.0, 240.0])
    codes = 0.5 + 0.5 * (moved[..., :1] * np.cos(angles) + moved[..., 1:] * np.sin(angles))
    return Look(
        codes.astype(np.float32),
        f"motion {which}: to the right red, up green, left cyan, down violet; full colour at {scale:.4g} px, the 99th "
        "percentile of what moves; grey stands still",
    )
