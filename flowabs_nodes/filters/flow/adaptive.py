"""Section 6's "adaptive kernel based on the analysis of scene complexity": a smaller ETF kernel on small texture.

The paper names it as future work and gives no rule. This one asks of every pixel at which scale its surroundings have a
direction. With J = sum of m^2 (cos 2θ, sin 2θ) under a Gaussian, m the gradient's magnitude and θ its orientation, |J|
is how much the gradients under it agree. Per kernel radius r,

    agreement = |mean of J_1 within r| / (mean of |J_1| within r),

J_1 that of the pixel and those beside it: 1 along an edge, near 0 where small edges run every way. The kernel is the
largest of r, r/2, r/4 ... 2.5 px whose agreement is enough, so none that averages small shapes away. Noise has no
direction even beside a pixel, sum |J_1| much below sum m^2: it keeps the full kernel, which is there to smooth it.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters.flow.gradient import gradient
from flowabs_nodes.filters.gaussian_blur import blur

_SMALLEST = 2.5  # px: 21 pixels; the paper draws such texture with 3
_FINE = 1.0  # px, sigma: the pixel and those beside it
_AGREEMENT = 0.5  # edges and corners of photographs have more, nets and dots 0.2
_DIRECTION = 0.5  # |J_1| of m^2: white noise has 0.4, drawn texture 0.65


def radii(radius: float) -> list[float]:
    """The kernel radii to choose from: ``radius``, its half, its quarter ..., the last 2.5 pixels."""
    sizes = [radius]
    while sizes[-1] > _SMALLEST:
        sizes.append(max(sizes[-1] / 2, _SMALLEST))
    return sizes


def kernel_choice(code: Array, radius: float) -> npt.NDArray[np.uint8]:
    """Which of ``radii(radius)`` each pixel takes, (H, W); 0 is the full one.

    ``code`` is the picture without any blur: blurred noise looks like texture.
    """
    tangent, magnitude = gradient(code)
    _, exponent = np.frexp(magnitude.max())
    weight = np.square(np.ldexp(magnitude, -exponent))  # at most 1: no number overflows, and the scale loses no bit
    c = weight * (tangent[..., 0] ** 2 - tangent[..., 1] ** 2)
    s = weight * (2 * tangent[..., 0] * tangent[..., 1])
    fine = blur(np.stack([c, s, weight], axis=2), _FINE)
    planes = np.concatenate([fine, np.hypot(fine[..., 0], fine[..., 1])[..., np.newaxis]], axis=2)
    choice = np.zeros(magnitude.shape, np.uint8)
    found = np.zeros(magnitude.shape, bool)
    sizes = radii(radius)
    for k, size in enumerate(sizes):
        around = blur(planes, size / 2)
        if k == 0:
            found |= around[..., 3] < np.float32(_DIRECTION) * around[..., 2]
        agrees = np.hypot(around[..., 0], around[..., 1]) >= np.float32(_AGREEMENT) * around[..., 3]
        choice[~found & (agrees | (k == len(sizes) - 1))] = k
        found |= agrees
    return choice
