"""Eqs. 10 and 11 for tangents of any length, slower than what there is for those that are about unit vectors."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.filters.arguments import Array
from flowabs_nodes.filters.blocks import COLUMNS, Block, first_pixel, inline, scratch, u
from flowabs_nodes.filters.kernels import kernel
from flowabs_nodes.filters.sampling import find, new_between, read, read_between, records
from flowabs_nodes.filters.threads import over_rows
from flowabs_nodes.filters.walk import new_walk, start, step


def along(planes: Array, flow: Array, weights: npt.NDArray[np.float64], sampling: str) -> Array:
    """:func:`~flowabs_nodes.filters.flow_blur.along`."""
    return _each(planes, lambda image, out: (_along, image, flow, weights, sampling == "nearest", out))


def across(planes: Array, flow: Array, taps: npt.NDArray[np.float64]) -> Array:
    """:func:`~flowabs_nodes.filters.gradient_line.across`."""
    return _each(planes, lambda image, out: (_across, image, flow, taps, out))


def _each(planes: Array, call: Any) -> Array:
    result = np.empty_like(planes)
    for c, plane in enumerate(planes):
        image = records(plane)
        out = np.empty_like(image)
        kernel, *arguments = call(image, out)
        over_rows(kernel, plane.shape[0], *arguments)
        result[c] = out[..., 0]
    return result


@kernel
def _along(first: int, last: int, image: Any, flow: Any, weights: Any, to_nearest: bool, result: Any) -> None:
    height, width, channels = image.shape
    source, tangents, target = image.reshape(-1), flow.reshape(-1), result.reshape(-1)
    walk, between, values, total = new_walk(), new_between(), scratch(np.float32, 4), scratch(np.float32, 4)
    for y in range(first, last):
        for x in range(0, width, COLUMNS):
            block = Block(x, y, u(min(COLUMNS, width - x)), width, height)
            at, size = u(channels) * first_pixel(block), u(channels) * block.size
            for k in range(size):
                total[k] = np.float32(weights[0]) * source[at + k]
            for way in range(2):
                start(walk, tangents, way, block)
                for s in range(1, weights.size):
                    step(walk, tangents, block)
                    if to_nearest:
                        read(source, walk.pixel, values, block, channels)
                    else:
                        find(walk.dx, walk.dy, between, block)
                        read_between(source, between, values, block, channels)
                    for k in range(size):
                        total[k] += np.float32(weights[u(s)]) * values[k]
            for k in range(size):
                target[at + k] = total[k]


@kernel
def _across(first: int, last: int, image: Any, flow: Any, taps: Any, result: Any) -> None:
    height, width, channels = image.shape
    source, tangents, target = image.reshape(-1), flow.reshape(-1), result.reshape(-1)
    dx, dy = scratch(np.float64, 1), scratch(np.float64, 1)
    between, values, total = new_between(), scratch(np.float32, 4), scratch(np.float32, 4)
    for y in range(first, last):
        for x in range(0, width, COLUMNS):
            block = Block(x, y, u(min(COLUMNS, width - x)), width, height)
            at, size = u(channels) * first_pixel(block), u(channels) * block.size
            for k in range(size):
                total[k] = np.float32(taps[0]) * source[at + k]
            for n in range(1 - taps.size, taps.size):
                if n == 0:
                    continue
                _line(tangents, n, dx, dy, block)
                find(dx, dy, between, block)
                read_between(source, between, values, block, channels)
                for k in range(size):
                    total[k] += np.float32(taps[u(abs(n))]) * values[k]
            for k in range(size):
                target[at + k] = total[k]


@inline
def _line(flow: Any, n: int, dx: Any, dy: Any, block: Block) -> None:
    """Offsets of the points l_x(n); where the tangent is zero, that is the pixel itself."""
    first = u(2) * first_pixel(block)
    for i in range(block.size):
        dx[i] = n * np.float64(flow[first + u(2) * i + u(1)])
        dy[i] = -n * np.float64(flow[first + u(2) * i])
