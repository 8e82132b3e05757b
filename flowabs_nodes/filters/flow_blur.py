"""Gaussian blur along the flow: eq. 11 for any picture."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from numba import prange

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import arguments, gaussian
from flowabs_nodes.filters.arguments import Array
from flowabs_nodes.filters.blocks import COLUMNS, Block, first_pixel, scratch, u
from flowabs_nodes.filters.kernels import kernel, parallel_kernel
from flowabs_nodes.filters.sampling import SAMPLINGS, find, new_between, read, read_between, records
from flowabs_nodes.filters.walk import new_walk, start, step


def flow_blur(image: npt.ArrayLike, flow: npt.ArrayLike, sigma: float = 2.0, sampling: str = "bilinear") -> Array:
    """Gaussian blur of each channel along the flow.

    Parameters
    ----------
    image
        (H, W) or (H, W, C) with up to four channels, any scale; RGBA premultiplied.
    flow
        (H, W, 2), unit tangents, x right and y down; the sign has no meaning.
    sigma
        Standard deviation in pixels along the curve, 0 to 10,000; 0 gives a copy. Cut at ceil(3 sigma).
    sampling
        How the curve is read, "bilinear" or "nearest" pixel.

    Returns
    -------
    The blurred image, float32, of the same shape.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    image = arguments.any_channels("image", image)
    flow = arguments.flow_field(flow, image.shape)
    sigma = arguments.number("sigma", sigma, min=0, max=10_000)
    arguments.choice("sampling", sampling, SAMPLINGS)
    if image.ndim == 3 and image.shape[2] > 4:
        raise ArgumentError(f"image: expected up to 4 channels, found {image.shape[2]}", parameter="image")
    if sigma == 0:
        return image.copy()
    blurred = along(records(image), flow, gaussian.half(sigma), sampling)
    channels = 1 if image.ndim == 2 else image.shape[2]
    return blurred[..., :channels].reshape(image.shape)


def along(image: Array, flow: Array, weights: npt.NDArray[np.float64], sampling: str) -> Array:
    """The weighted sum of ``image`` (H, W, 1 or 4) over the curve c_x of each pixel (eq. 11).

    ``weights`` are those of the steps 0, 1 .. to either side.
    """
    result = np.empty_like(image)
    _along(image, flow, weights.astype(np.float32), sampling == "nearest", result)
    return result


@parallel_kernel
def _along(image: Any, flow: Any, weights: Any, to_nearest: bool, result: Any) -> None:
    height, width, channels = image.shape
    source, tangents, target = image.reshape(-1), flow.reshape(-1), result.reshape(-1)
    for y in prange(height):
        _along_row(source, channels, tangents, weights, to_nearest, np.int64(y), width, height, target)


@kernel
def _along_row(
    image: Any,
    channels: int,
    flow: Any,
    weights: Any,
    to_nearest: bool,
    y: int,
    width: int,
    height: int,
    result: Any,
) -> None:
    walk, between, values, total = new_walk(), new_between(), scratch(np.float32, 4), scratch(np.float32, 4)
    for x in range(0, width, COLUMNS):
        block = Block(x, y, u(min(COLUMNS, width - x)), width, height)
        first, size = u(channels) * first_pixel(block), u(channels) * block.size
        for k in range(size):
            total[k] = weights[u(0)] * image[first + k]
        for way in range(2):
            start(walk, flow, way, block)
            for s in range(1, weights.size):
                step(walk, flow, block)
                if to_nearest:
                    read(image, walk.pixel, values, block, channels)
                else:
                    find(walk.dx, walk.dy, between, block)
                    read_between(image, between, values, block, channels)
                for k in range(size):
                    total[k] += weights[u(s)] * values[k]
        for k in range(size):
            result[first + k] = total[k]
