"""Look at ids, each in a colour of its own."""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.image import Image
from flowabs_nodes.looking.look import Look


def look_at_ids(image: Image) -> Look:
    """Return a colour for each id, the same on every frame and in every picture; 0, the background, is black."""
    ids = image.pixels[..., 0].astype(np.uint32)
    known, places = np.unique(ids, return_inverse=True)
    colors = np.where(known[:, None] == 0, np.float32(0), _colors(known))
    count = int((known != 0).sum())
    said = f"{count} {'id' if count == 1 else 'ids'}, each in a colour of its own"
    background = "; 0, the background, is black" if (known == 0).any() else ""
    return Look(colors[places.reshape(ids.shape)].astype(np.float32), said + background)


def _colors(ids: np.ndarray) -> Array:
    """Return bright colours (N, 3) of ids (N,): by their hash a hue, and a lightness so that equal hues differ."""
    mixed = ids.astype(np.uint32)
    for shift, factor in ((16, 0x85EBCA6B), (13, 0xC2B2AE35)):  # MurmurHash3's last steps: neighbours become strangers
        mixed = (mixed ^ (mixed >> np.uint32(shift))) * np.uint32(factor)
    mixed ^= mixed >> np.uint32(16)
    hue = (mixed & np.uint32(0xFFFF)) / 65536
    light = 0.6 + 0.4 * (mixed >> np.uint32(16)) / 65536
    turns = hue[:, None] - np.array([0.0, 1 / 3, 2 / 3])
    return np.asarray(light[:, None] * (0.55 + 0.45 * np.cos(2 * np.pi * turns)), np.float32)
