"""Section 6's "adaptive kernel based on the analysis of scene complexity": a smaller ETF footprint on small texture.

The paper names it as future work and gives no rule. The rule here asks at which scale a pixel's surroundings have one
direction. With m the gradient's magnitude and θ its orientation, let J_1 be the sum of m^2 (cos 2θ, sin 2θ) over the
pixel and those beside it (under a Gaussian). Then, with means within a radius r (under a Gaussian of sigma r/2),

    agreement(r) = |mean of J_1| / mean of |J_1|

is 1 along an edge, and near 0 where small edges run every way. A pixel takes the largest of the radii r, r/2, r/4 ..
2.5 px at which the agreement is high enough, so a footprint does not average small shapes away. Noise has no direction
even beside a pixel: the sum of |J_1| is much below the sum of m^2. Noise keeps the full footprint, which smooths it.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters.flow.gradient import gradient
from flowabs_nodes.filters.gaussian_blur import blur

_SMALLEST = 2.5  # px, a footprint of 21 pixels; the paper draws small texture with mu = 3 (Fig. 10)
_FINE = 1.0  # px, sigma of the Gaussian of J_1
_AGREEMENT = 0.5  # edges and corners of photographs have more, nets and dots 0.2
_DIRECTION = 0.5  # mean |J_1| / mean m^2: white noise has 0.4, drawn texture 0.65


def radii(radius: float) -> list[float]:
    """Return the radii to choose from, in pixels: ``radius``, its half, its quarter .., the last one 2.5."""
    sizes = [radius]
    while sizes[-1] > _SMALLEST:
        sizes.append(max(sizes[-1] / 2, _SMALLEST))
    return sizes


def kernel_choice(code: Array, radius: float, mask: Array | None = None) -> npt.NDArray[np.uint8]:
    """Return which of ``radii(radius)`` each pixel takes: (H, W) uint8, 0 for the full radius.

    ``code``, (H, W) or (H, W, 3), is the picture before any blur: blurred noise looks like texture. Magnitudes are
    multiplied by ``mask``, (H, W), if there is one.
    """
    tangent, magnitude = gradient(code)
    if mask is not None:
        magnitude = magnitude * mask
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
