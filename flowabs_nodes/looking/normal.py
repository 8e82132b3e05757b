"""Look at normals as colour."""

from __future__ import annotations

import numpy as np

from flowabs_nodes.image import Image
from flowabs_nodes.looking.look import Look


def look_at_normal(image: Image) -> Look:
    """Return X, Y, Z as red, green, blue: -1 is 0, 0 a middle grey, 1 is 1."""
    codes = np.nan_to_num(0.5 + 0.5 * image.pixels, nan=0.0, posinf=1.0, neginf=0.0).clip(0, 1)
    return Look(codes, "normals: X, Y, Z from -1 to 1 as red, green, blue from 0 to 1")
