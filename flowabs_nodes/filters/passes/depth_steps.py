"""Steps in depth between neighbouring pixels that planes, however grazing, do not make.

Let u be affine on planes (``affine_depth.py``), and a, b, c, d four pixels in a row. Between b and c

    own = (2 u_b - u_a) - u_c,  far = u_b - (2 u_c - u_d),  raw = u_b - u_c

are how far c lies behind the plane of a and b, how far b lies before the plane of c and d, and how far apart they are.
Where the three have one sign, the step is J = sign min(|own|, |far|, |raw|) / max(|u_b|, |u_c|), else 0. At a jump
between planes, |J| = 1 - Z_near / Z_far; planes and creases give 0. J > 0: b is nearer.
"""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.simd.jit import inlined
from flowabs_nodes.simd.lanes import Masks, absolute, maximum, minimum
from flowabs_nodes.simd.memory import load


@inlined
def relative_step(u: Array, far: float, unknown: float, x: int, y: int, x1: int, y1: int) -> float:
    """Return J between two neighbouring pixels; beyond the picture its border is repeated.

    ``far`` and ``unknown`` are those of :class:`~.affine_depth.Depth`.
    """
    a, b, c, d = _four(u, x, y, x1, y1)
    if b <= far and c <= far:
        return 0.0
    if (b <= far or c <= far) and max(b, c) >= unknown:
        # All that is known of the background is that it lies beyond what a file's numbers can say.
        a, b = unknown if a <= far else a, unknown if b <= far else b
        c, d = unknown if c <= far else c, unknown if d <= far else d
    own, beyond, raw = (2 * b - a) - c, b - (2 * c - d), b - c
    step = 0.0
    if raw > 0 and own > 0 and beyond > 0:
        step = min(own, beyond, raw) / max(abs(b), abs(c))
    elif raw < 0 and own < 0 and beyond < 0:
        step = max(own, beyond, raw) / max(abs(b), abs(c))
    return step


@inlined
def apart(u: Array, x: int, y: int, x1: int, y1: int) -> float:
    """Return how far, in u, the first pixel's surface lies before the second's at the crack between them."""
    a, b, c, d = _four(u, x, y, x1, y1)
    gap: float = (1.5 * b - 0.5 * a) - (1.5 * c - 0.5 * d)
    return gap


@inlined
def _four(u: Array, x: int, y: int, x1: int, y1: int) -> tuple[float, float, float, float]:
    """Return u of the pixel before two neighbours, of both, and of the one after them."""
    height, width = u.shape
    xa, ya = max(2 * x - x1, 0), max(2 * y - y1, 0)
    xd, yd = min(2 * x1 - x, width - 1), min(2 * y1 - y, height - 1)
    return np.float64(u[ya, xa]), np.float64(u[y, x]), np.float64(u[y1, x1]), np.float64(u[yd, xd])


@inlined
def may_step(u: Array, pixel: int, forward: int, limit: float) -> Masks:
    """Return for sixteen pixels from ``pixel`` of a flat picture on whether |J| may be above ``limit``.

    ``forward`` is how many pixels further on the other side of the crack is. It is never False where J is above.
    """
    a, b = load(u, pixel - forward), load(u, pixel)
    c, d = load(u, pixel + forward), load(u, pixel + 2 * forward)
    own, beyond, raw = (b - a) + (b - c), (b - c) + (d - c), b - c
    one_sign = ((raw > 0.0) & (own > 0.0) & (beyond > 0.0)) | ((raw < 0.0) & (own < 0.0) & (beyond < 0.0))
    least = minimum(minimum(absolute(own), absolute(beyond)), absolute(raw))
    return one_sign & (least > limit * maximum(absolute(b), absolute(c)))
