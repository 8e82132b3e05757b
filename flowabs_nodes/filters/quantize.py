"""Region flattening (section 4.1): luminance in bins of one size, with hard or soft steps."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from numba import prange

from flowabs_nodes.filters import arguments
from flowabs_nodes.filters.arguments import Array
from flowabs_nodes.filters.kernels import parallel_kernel


def quantize(lstar: npt.ArrayLike, levels: int = 8, softness: float = 0.0) -> Array:
    """Lightness in ``levels`` bins of 0..100: the middle of the bin that it falls in.

    With D = 100 / levels and u = L* / D: Q = (max(1, ceil(u - 1e-3)) - 1/2) D. White is in bin ``levels``, zero and
    below in bin 1, and bins go on above white. With softness s, Q = (e - 1/2 + 3 t^2 - 2 t^3) D, where e = round(u) and
    t = clamp((u - e) / s + 1/2, 0, 1).

    Parameters
    ----------
    lstar
        L* (H, W), white 100.
    levels
        Number of bins up to white, at least 1; typically 4 to 10.
    softness
        Width of the step from one bin to the next, 0 (hard) to 1, of a bin.

    Returns
    -------
    Q, (H, W) float32, in L*.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    lstar = arguments.plane("lstar", lstar)
    levels = arguments.whole("levels", levels, min=1)
    softness = arguments.number("softness", softness, min=0, max=1)
    flat = np.empty_like(lstar)
    _quantize(lstar, 100.0 / levels, softness, flat)
    return flat


@parallel_kernel
def _quantize(lstar: Any, size: float, softness: float, flat: Any) -> None:
    height, width = lstar.shape
    for y in prange(height):
        for x in range(width):
            level = lstar[y, x] / size
            if softness == 0:
                q = max(1.0, np.ceil(level - 1e-3)) - 0.5
            else:
                edge = np.rint(level)
                t = min(max((level - edge) / softness + 0.5, 0.0), 1.0)
                q = edge - 0.5 + t * t * (3.0 - 2.0 * t)
            flat[y, x] = np.float32(q * size)
