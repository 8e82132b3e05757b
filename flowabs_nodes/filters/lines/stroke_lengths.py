"""The lengths in pixels that strokes are measured with: all come of ``min_length`` and ``taper``."""

from __future__ import annotations

import math

#: Of ``min_length``: up to the first nothing is left of a stroke, from the second on all of it.
SHORTEST, LONGEST = 0.5, 1.5


def longest_walk(min_length: float, taper: float) -> int:
    """Return how many steps along the flow are taken each way, at most."""
    return math.ceil(max(LONGEST * min_length, taper))


def gap(min_length: float, taper: float) -> float:
    """Return how long a gap in a stroke is that leaves 1/e of what lies beyond it."""
    return max(min_length, taper) / 5


def smoothing(min_length: float, taper: float) -> float:
    """Return the sigma of the Gaussian that averages widths over the middle of the strokes around a pixel."""
    return max(0.1 * max(min_length, taper), 1.5)


def widest(min_length: float, taper: float) -> int:
    """Return how far the rim of a stroke may be from a pixel in it; what is wider is an area, whose rim alone moves."""
    return math.ceil(max(min_length / 2, taper / 2, 16.0))
