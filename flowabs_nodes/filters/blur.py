"""The plain Gaussian blur, separable, border repeated."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from numba import prange

from flowabs_nodes.filters import arguments, gaussian
from flowabs_nodes.filters.arguments import Array
from flowabs_nodes.filters.kernels import kernel, parallel_kernel


def blur(image: npt.ArrayLike, sigma: float = 1.0) -> Array:
    """Gaussian blur of each channel, the border repeated.

    Parameters
    ----------
    image
        (H, W) or (H, W, C), any scale; RGBA premultiplied.
    sigma
        Standard deviation in pixels, 0 to 10,000; 0 gives a copy. Cut at ceil(3 sigma).

    Returns
    -------
    The blurred image, float32, of the same shape.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a sigma out of range.
    """
    image = arguments.any_channels("image", image)
    sigma = arguments.number("sigma", sigma, min=0, max=10_000)
    if sigma == 0:
        return image.copy()
    return separable(image, gaussian.half(sigma))


def separable(image: Array, weights: npt.NDArray[np.float64]) -> Array:
    """The weighted sum over columns, then rows; ``weights`` are those of the offsets 0, 1 .. to either side."""
    channels = 1 if image.ndim == 2 else image.shape[2]
    rows = image.reshape(image.shape[0], -1)
    blurred = np.empty_like(rows)
    _blur(rows, channels, weights, blurred)
    return blurred.reshape(image.shape)


@parallel_kernel
def _blur(rows: Array, channels: int, weights: npt.NDArray[np.float64], blurred: Array) -> None:
    """Each row on its own: first down the columns into a padded row, then along it."""
    height, width = rows.shape
    steps = weights.size - 1
    margin = steps * channels
    for y in prange(height):
        padded = np.zeros(width + 2 * margin)
        centre = padded[margin : margin + width]
        _add(weights[0], rows[y], centre)
        for k in range(1, steps + 1):
            _add_pair(weights[k], rows[max(y - k, 0)], rows[min(y + k, height - 1)], centre)
        for x in range(margin):
            padded[x] = centre[x % channels]
            padded[margin + width + x] = centre[width - channels + x % channels]
        total = np.zeros(width)
        _add(weights[0], centre, total)
        for k in range(1, steps + 1):
            left = (steps - k) * channels
            right = (steps + k) * channels
            _add_pair(weights[k], padded[left : left + width], padded[right : right + width], total)
        out = blurred[y]
        for x in range(width):
            out[x] = total[x]


@kernel
def _add(weight: float, a: npt.NDArray[np.floating], total: npt.NDArray[np.float64]) -> None:
    for x in range(total.size):
        total[x] += weight * a[x]


@kernel
def _add_pair(
    weight: float, a: npt.NDArray[np.floating], b: npt.NDArray[np.floating], total: npt.NDArray[np.float64]
) -> None:
    for x in range(total.size):
        total[x] += weight * (np.float64(a[x]) + np.float64(b[x]))
