"""The choice of kernels by scene complexity, and the flow it gives, in float64."""

from __future__ import annotations

import numpy as np

from tests.naive import etf as naive
from tests.naive.fdog import blur


def radii(radius):
    sizes = [radius]
    while sizes[-1] > 2.5:
        sizes.append(max(sizes[-1] / 2, 2.5))
    return sizes


def kernel_choice(code, radius):
    """Tensors that agree: |sum J_1| >= half of sum |J_1|, where |J_1| is at least half of m^2 within ``radius``."""
    tangent, magnitude = naive.gradient(code)
    double_angle = magnitude**2 * (tangent[..., 0] + 1j * tangent[..., 1]) ** 2
    fine = _blur(double_angle, 1.0)
    directed = blur(np.abs(fine), radius / 2) >= 0.5 * blur(blur(magnitude**2, 1.0), radius / 2)
    agreement = [np.abs(_blur(fine, r / 2)) >= 0.5 * blur(np.abs(fine), r / 2) for r in radii(radius)[:-1]]
    largest = np.argmax([*agreement, np.ones(magnitude.shape, bool)], axis=0)
    return np.where(directed, largest, 0)


def etf(code, radius, iterations, kernel, choice):
    """Eq. 1, each pixel with the kernel that is chosen for it."""
    tangent, magnitude = naive.gradient(code)
    strength = magnitude / magnitude.max()
    tangent = naive.flow_fill(tangent, magnitude, 0.0)
    d = range(-int(np.ceil(radius)), int(np.ceil(radius)) + 1)
    for _ in range(iterations):
        for p in range(1 if kernel == "full" else 2):
            smoothed = [naive._smooth(tangent, strength, _offsets(kernel, p, r, d)) for r in radii(radius)]
            tangent = np.choose(choice[..., None], smoothed)
    return tangent


def _offsets(kernel, p, r, d):
    if kernel == "full":
        return [(dx, dy) for dy in d for dx in d if dx * dx + dy * dy < r * r]
    return [(k, 0) if p == 0 else (0, k) for k in d if abs(k) < r]


def _blur(values, sigma):
    return blur(values.real, sigma) + 1j * blur(values.imag, sigma)
