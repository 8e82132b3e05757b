"""Gaussians as every filter samples them: cut at ceil(3 sigma), taken at whole steps, normalised to a sum of 1."""

from __future__ import annotations

import math

import numpy as np

from flowabs_nodes.array_types import Float64


def radius(sigma: float) -> int:
    """Return the number of steps to either side of the centre: ceil(3 sigma)."""
    return math.ceil(3 * sigma)


def half(sigma: float, steps: int | None = None) -> Float64:
    """Return one side of G(sigma): the weights of the offsets 0, 1 .. ``steps``, ceil(3 sigma) unless given.

    Both sides together, the centre counted once, sum to 1. With a ``sigma`` of 0 pixels the centre has all the weight.
    """
    steps = radius(sigma) if steps is None else steps
    weights = np.zeros(steps + 1)
    weights[0] = 1.0
    if sigma > 0.01:  # below, the neighbours' weights underflow
        weights[1:] = np.exp(-(np.arange(1, steps + 1) ** 2) / (2 * sigma * sigma))  # eq. 7
    both = 2 * float(weights.sum()) - 1  # the centre, 1, counted once
    return weights / both


def every(step: int, weights: Float64) -> Float64:
    """Return one side's weights with those of the offsets 0, step, 2 step .. alone.

    They sum to 1 on both sides and have the variance of ``weights``: of what is smoother than ``step`` they make the
    same sum.
    """
    if step == 1:
        return weights
    offsets = np.arange(weights.size)
    kept = np.where(offsets % step == 0, weights, 0)
    kept *= (weights * offsets**2).sum() / max(float((kept * offsets**2).sum()), 1e-30)
    kept[0] = 1 - 2 * float(kept[1:].sum())  # the centre, counted once
    return kept


#: sigma_s / sigma_c in eq. 8: at 1.6 the difference of Gaussians is close to a Laplacian of Gaussian (Marr, Hildreth).
SURROUND = 1.6

#: Sigma of the stretch on which evidence for a line is looked for, as a multiple of sigma_m.
LONGER = 3


def difference(sigma_c: float, rho: float, sigma_s: float | None = None, step: int = 1) -> Float64:
    """Return one side of f (eq. 8): G(sigma_c) - rho G(sigma_s), both over ceil(3 sigma_s) steps.

    With ``step`` only at the offsets 0, step, 2 step .., as :func:`every` has it.
    """
    inner, outer = (every(step, side) for side in centre_and_surround(sigma_c, sigma_s))
    return inner - rho * outer  # eq. 8


def centre_and_surround(sigma_c: float, sigma_s: float | None = None) -> tuple[Float64, Float64]:
    """Return one side each of G(sigma_c) and of G(sigma_s), both over ceil(3 sigma_s) steps.

    ``sigma_s`` is 1.6 sigma_c unless given.
    """
    sigma_s = SURROUND * sigma_c if sigma_s is None else sigma_s
    steps = radius(sigma_s)
    return half(sigma_c, steps), half(sigma_s, steps)
