"""Look at a depth, from near to far."""

from __future__ import annotations

import numpy as np

from flowabs_nodes.filters.background import FAR
from flowabs_nodes.image import Image
from flowabs_nodes.looking.look import Look
from flowabs_nodes.looking.stretch import finite_range, grey, stretched

#: A few pixels may be much nearer or farther than all others.
_PERCENTILES = (1.0, 99.0)
#: The grey of the farthest thing, which is not the background.
_FAR_GREY = np.float32(0.1)


def look_at_depth(image: Image) -> Look:
    """Return near white and far dark grey, by percentiles of what is there; the background is black."""
    values = image.pixels[..., 0]
    there = np.isfinite(values) & (values < FAR)
    if not there.any():
        return Look(grey(np.zeros_like(values)), "depth: nothing but background, black")
    near, far = finite_range(values[there], _PERCENTILES)
    codes = np.where(there, 1 - (1 - _FAR_GREY) * stretched(values, near, far), np.float32(0))
    said = f"depth from {near:.4g} (white) to {far:.4g} (dark grey), its 1st and 99th percentile"
    return Look(grey(codes), said if there.all() else f"{said}; background black")
