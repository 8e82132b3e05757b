"""The gradient axis l_x (section 3.1): unit steps along (t.y, -t.x), across the flow."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from numba import prange

from flowabs_nodes.filters.arguments import Array
from flowabs_nodes.filters.blocks import COLUMNS, Block, first_pixel, inline, scratch, u
from flowabs_nodes.filters.kernels import kernel, parallel_kernel
from flowabs_nodes.filters.sampling import find, new_between, read_between


@inline
def line(flow: Any, n: int, dx: Any, dy: Any, block: Block) -> None:
    """Offsets of the points l_x(n); where the tangent is zero, that is the pixel itself."""
    first = u(2) * first_pixel(block)
    for i in range(block.size):
        dx[i] = n * np.float64(flow[first + u(2) * i + u(1)])
        dy[i] = -n * np.float64(flow[first + u(2) * i])


def across(image: Array, flow: Array, taps: npt.NDArray[np.float64]) -> Array:
    """Eq. 10: the weighted sum of ``image`` (H, W, 1 or 4) over the gradient axis of each pixel, read bilinearly.

    ``taps`` are the weights f of the steps 0, 1 .. to either side.
    """
    result = np.empty_like(image)
    _across(image, flow, taps.astype(np.float32), result)
    return result


@parallel_kernel
def _across(image: Any, flow: Any, taps: Any, result: Any) -> None:
    height, width, channels = image.shape
    source, tangents, target = image.reshape(-1), flow.reshape(-1), result.reshape(-1)
    for y in prange(height):
        _across_row(source, channels, tangents, taps, np.int64(y), width, height, target)


@kernel
def _across_row(image: Any, channels: int, flow: Any, taps: Any, y: int, width: int, height: int, result: Any) -> None:
    dx, dy = scratch(np.float64, 1), scratch(np.float64, 1)
    between, values, total = new_between(), scratch(np.float32, 4), scratch(np.float32, 4)
    for x in range(0, width, COLUMNS):
        block = Block(x, y, u(min(COLUMNS, width - x)), width, height)
        first, size = u(channels) * first_pixel(block), u(channels) * block.size
        for k in range(size):
            total[k] = taps[u(0)] * image[first + k]
        for side in range(2):
            for n in range(1, taps.size):
                line(flow, n if side == 0 else -n, dx, dy, block)
                find(dx, dy, between, block)
                read_between(image, between, values, block, channels)
                for k in range(size):
                    total[k] += taps[u(n)] * values[k]
        for k in range(size):
            result[first + k] = total[k]
