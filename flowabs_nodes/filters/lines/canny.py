"""Canny's edge detector [27] by OpenCV, with which the paper compares FDoG (Fig. 14b)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters import validate
from flowabs_nodes.filters.flow.gradient import gradient
from flowabs_nodes.filters.opencv import opencv

_LARGEST = 32767  # OpenCV takes gradients as 16-bit integers


def canny(code: npt.ArrayLike, sigma: float = 1.0, low: float = 0.1, high: float = 0.2) -> Array:
    """Draw edges one pixel wide: ridges of the gradient's magnitude above ``low`` that touch a ridge above ``high``.

    OpenCV's ``Canny`` with ``L2gradient`` finds ridges and applies the thresholds. It gets this package's gradient, 3x3
    Sobel after a Gaussian blur, scaled so that the largest magnitude of the picture is 32767, and rounded.

    Parameters
    ----------
    code
        Code values, (H, W).
    sigma
        Sigma of the Gaussian blur before the gradient, in pixels, 0 to 10,000.
    low, high
        Thresholds, 0 to 1, as parts of the largest gradient of the picture: an edge has to reach the larger of the two
        somewhere, and goes on while it stays above the smaller.

    Returns
    -------
    Lines, (H, W) float32, 1 paper and 0 ink. A picture without any gradient is paper.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    FlowabsError
        "missing-package" where OpenCV is not installed.
    """
    code = validate.plane("code", code)
    sigma = validate.number("sigma", sigma, min=0, max=10_000)
    low = validate.number("low", low, min=0, max=1)
    high = validate.number("high", high, min=0, max=1)
    cv2 = opencv("canny")
    tangent, magnitude = gradient(code, sigma)
    largest = float(magnitude.max())
    if largest == 0:
        return np.ones_like(code)
    size = magnitude * (_LARGEST / largest)
    gx = np.rint(size * tangent[..., 1]).astype(np.int16)
    gy = np.rint(size * -tangent[..., 0]).astype(np.int16)
    edges = cv2.Canny(gx, gy, low * _LARGEST, high * _LARGEST, L2gradient=True)
    lines: Array = np.where(edges > 0, np.float32(0), np.float32(1))
    return lines
