"""Gaussians as every filter samples them: cut at ceil(3 sigma), taken at whole steps, normalised to sum 1."""

from __future__ import annotations

import math

import numpy as np

from flowabs_nodes.array_types import Float64


def radius(sigma: float) -> int:
    """Number of steps to each side: ceil(3 sigma)."""
    return math.ceil(3 * sigma)


def half(sigma: float, steps: int | None = None) -> Float64:
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


#: sigma_s / sigma_c of eq. 8: with it a difference of Gaussians is about the Laplacian of a Gaussian (Marr, Hildreth).
SURROUND = 1.6


def difference(sigma_c: float, rho: float) -> Float64:
    """Return one side of f (eq. 8): G(sigma_c) - rho G(sigma_s), both over ceil(3 sigma_s) steps."""
    inner, outer = centre_and_surround(sigma_c)
    return inner - rho * outer


def centre_and_surround(sigma_c: float) -> tuple[Float64, Float64]:
    """Return one side each of G(sigma_c) and of G(sigma_s), sigma_s = 1.6 sigma_c, both over ceil(3 sigma_s) steps."""
    sigma_s = SURROUND * sigma_c
    steps = radius(sigma_s)
    return half(sigma_c, steps), half(sigma_s, steps)
