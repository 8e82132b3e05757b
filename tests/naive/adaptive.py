"""The choice of ETF footprints by scene complexity, and the flow they give, in float64."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tests.naive import etf as naive
from tests.naive.etf import Float64
from tests.naive.fdog import blur


def radii(radius: float) -> list[float]:
    """Return ``radius``, its half, its quarter .., the last one 2.5."""
    sizes = [radius]
    while sizes[-1] > 2.5:
        sizes.append(max(sizes[-1] / 2, 2.5))
    return sizes


def kernel_choice(code: npt.ArrayLike, radius: float) -> npt.NDArray[np.int64]:
    """Return which of ``radii(radius)`` each pixel takes: the first at which the tensors J_1 around it agree.

    They agree where |mean J_1| is at least half of mean |J_1|. Where mean |J_1| is less than half of mean m^2 within
    ``radius``, the pixel takes the full radius.
    """
    tangent, magnitude = naive.gradient(code)
    double_angle = magnitude**2 * (tangent[..., 0] + 1j * tangent[..., 1]) ** 2  # m^2 (cos 2θ + i sin 2θ)
    fine = _blur(double_angle, 1.0)
    directed = blur(np.abs(fine), radius / 2) >= 0.5 * blur(blur(magnitude**2, 1.0), radius / 2)
    agreement = [np.abs(_blur(fine, r / 2)) >= 0.5 * blur(np.abs(fine), r / 2) for r in radii(radius)[:-1]]
    largest = np.argmax([*agreement, np.ones(magnitude.shape, bool)], axis=0)
    return np.where(directed, largest, 0)


def etf(code: npt.ArrayLike, radius: float, iterations: int, kernel: str, choice: npt.NDArray[np.integer]) -> Float64:
    """Return the flow of eq. 1, summed at each pixel over the footprint of ``radii(radius)[choice]``."""
    tangent, magnitude = naive.gradient(code)
    strength = magnitude / magnitude.max()
    tangent = naive.flow_fill(tangent, magnitude, 0.0)
    d = range(-int(np.ceil(radius)), int(np.ceil(radius)) + 1)
    for _ in range(iterations):
        for p in range(1 if kernel == "full" else 2):
            smoothed = [naive._smooth(tangent, strength, _offsets(kernel, p, r, d)) for r in radii(radius)]
            tangent = np.choose(choice[..., None], smoothed)
    return tangent


def _offsets(kernel: str, p: int, r: float, d: range) -> list[tuple[int, int]]:
    """Return the pixels of the footprint of radius r in pass p of an iteration."""
    if kernel == "full":
        return [(dx, dy) for dy in d for dx in d if dx * dx + dy * dy < r * r]  # eq. 2
    return [(k, 0) if p == 0 else (0, k) for k in d if abs(k) < r]


def _blur(values: npt.NDArray[np.complex128], sigma: float) -> npt.NDArray[np.complex128]:
    return blur(values.real, sigma) + 1j * blur(values.imag, sigma)
