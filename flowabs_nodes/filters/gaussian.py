"""Gaussians as every filter samples them: cut at ceil(3 sigma), taken at whole steps, normalised to sum 1."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt


def radius(sigma: float) -> int:
    """Number of steps to each side: ceil(3 sigma)."""
    return math.ceil(3 * sigma)


def half(sigma: float, steps: int | None = None) -> npt.NDArray[np.float64]:
    """One side of G(sigma) (eq. 7): weights of the offsets 0, 1 .. ``steps`` (ceil(3 sigma) unless given).

    Both sides together, the centre counted once, sum to 1. ``sigma`` 0 is all centre.
    """
    steps = radius(sigma) if steps is None else steps
    weights = np.zeros(steps + 1)
    weights[0] = 1.0
    if sigma > 0.01:  # below, the neighbours' weights underflow
        weights[1:] = np.exp(-(np.arange(1, steps + 1) ** 2) / (2 * sigma * sigma))
    both = 2 * float(weights.sum()) - 1  # the centre, 1, counted once
    return weights / both


def difference(sigma_c: float, rho: float) -> npt.NDArray[np.float64]:
    """One side of f (eq. 8): G(sigma_c) - rho G(1.6 sigma_c), both over ceil(3 * 1.6 sigma_c) steps."""
    sigma_s = 1.6 * sigma_c
    steps = radius(sigma_s)
    return half(sigma_c, steps) - rho * half(sigma_s, steps)
