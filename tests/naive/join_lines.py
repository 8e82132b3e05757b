"""Two drawings joined, in float64."""

from __future__ import annotations

import numpy as np

from tests.naive.fdog import smoothstep


def join_lines(lines, under, gap):
    """Return ``lines`` with the ink of ``under`` that is farther away than ``gap``."""
    a, b = np.clip(1 - lines.astype(np.float64), 0, 1), 1 - under.astype(np.float64)
    height, width = a.shape
    reach = int(np.ceil(gap + 1))
    padded = np.pad(a, reach)
    most = np.zeros(a.shape)
    for v in range(2 * reach + 1):
        for u in range(2 * reach + 1):
            weight = np.clip(gap + 0.5 - np.hypot(v - reach, u - reach), 0, 1)
            most = np.maximum(most, weight * padded[v : v + height, u : u + width])
    near = smoothstep(0.2, 0.8, most) if gap > 0 else 0
    return 1 - np.maximum(1 - lines, b * (1 - near))
