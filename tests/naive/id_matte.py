"""The matte of some ids, pixel by pixel, in float64."""

from __future__ import annotations

import numpy as np


def id_matte(ids, chosen, coverage):
    """Return the matte of ``chosen``, a set of ids: what an id leaves of its pixel goes to those around it."""
    height, width = ids.shape
    matte = np.zeros(ids.shape)
    for y in range(height):
        for x in range(width):
            own = ids[y, x]
            around = [
                ids[v, u]
                for v in range(max(y - 1, 0), min(y + 2, height))
                for u in range(max(x - 1, 0), min(x + 2, width))
                if ids[v, u] != own
            ]
            c = np.clip(coverage[y, x], 0, 1)
            share = np.mean([each in chosen for each in around]) if around else own in chosen
            matte[y, x] = (own in chosen) * c + (1 - c) * share
    return matte
