"""From response to lines: eq. 9, hard or soft."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import prange

from flowabs_nodes.filters import arguments
from flowabs_nodes.filters.arguments import Array
from flowabs_nodes.filters.kernels import parallel_kernel


def threshold(response: npt.ArrayLike, tau: float = 0.5, contrast: float | None = None, softness: float = 0.0) -> Array:
    """Lines: ink where H < -c, which is eq. 9 (H < 0 and 1 + tanh H < tau) for c = -atanh(tau - 1).

    Parameters
    ----------
    response
        H in code values, (H, W).
    tau
        Threshold of eq. 9, 0 to 1: 0 gives paper alone, 1 ink wherever H < 0. Not used when ``contrast`` is given.
    contrast
        c in code values, at least 0; None is -atanh(tau - 1).
    softness
        s in code values, at least 0: 0 is binary, else lines = smoothstep(-c - s, -c, H).

    Returns
    -------
    Lines, (H, W) float32, 1 paper and 0 ink.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    response = arguments.plane("response", response)
    tau = arguments.number("tau", tau, min=0, max=1)
    softness = arguments.number("softness", softness, min=0)
    if contrast is not None:
        contrast = arguments.number("contrast", contrast, min=0)
    elif tau == 0:
        contrast = math.inf
    else:
        contrast = (math.log(2 - tau) - math.log(tau)) / 2  # -atanh(tau - 1), also where tau - 1 rounds to -1
    lines = np.empty_like(response)
    _threshold(response, -contrast, softness, lines)
    return lines


@parallel_kernel
def _threshold(response: Any, paper: float, softness: float, lines: Any) -> None:
    """Paper from ``paper`` on. Compared in float64: the float32 next to it would be another threshold."""
    height, width = response.shape
    for y in prange(height):
        for x in range(width):
            if softness == 0 or paper == -np.inf:
                lines[y, x] = np.float32(0.0) if response[y, x] < paper else np.float32(1.0)
            else:
                t = min(max((response[y, x] - paper) / softness + 1.0, 0.0), 1.0)
                lines[y, x] = np.float32(t * t * (3.0 - 2.0 * t))
