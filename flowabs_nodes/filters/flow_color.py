"""The paper's Fig. 5: orientation as RGB."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from numba import prange

from flowabs_nodes.filters import arguments
from flowabs_nodes.filters.arguments import Array
from flowabs_nodes.filters.kernels import parallel_kernel

_HALF_ROOT_3 = np.sqrt(3) / 2


def flow_color(flow: npt.ArrayLike) -> Array:
    """Colour of each orientation, for comparing flows by eye or by number (Fig. 5).

    A tangent at angle θ (x right, y down) becomes ½ + ½ cos(2θ - φ) with φ = 0°, 120°, 240° for R, G, B. Opposite
    tangents are one orientation and one colour; turning by δ moves the colour by √(3/2) |sin δ| wherever it starts.

    Parameters
    ----------
    flow
        Tangents (H, W, 2), x then y. Longer ones count as unit vectors, shorter ones fade to grey.

    Returns
    -------
    RGB (H, W, 3) in [0, 1]: horizontal (1, ¼, ¼), vertical (0, ¾, ¾), zero tangents (½, ½, ½).

    Raises
    ------
    ArgumentError
        For another shape or dtype, or values that are not finite.
    """
    flow = arguments.flow_field(flow)
    rgb = np.empty((*flow.shape[:2], 3), np.float32)
    _color(flow, rgb)
    return rgb


@parallel_kernel
def _color(flow: Array, rgb: Array) -> None:
    for y in prange(flow.shape[0]):
        for x in range(flow.shape[1]):
            tx, ty = np.float64(flow[y, x, 0]), np.float64(flow[y, x, 1])
            norm = 2 * max(tx * tx + ty * ty, 1.0)
            c, s = (tx * tx - ty * ty) / norm, 2 * tx * ty / norm  # half of cos 2θ and sin 2θ
            rgb[y, x, 0] = 0.5 + c
            rgb[y, x, 1] = 0.5 - c / 2 + _HALF_ROOT_3 * s
            rgb[y, x, 2] = 0.5 - c / 2 - _HALF_ROOT_3 * s
