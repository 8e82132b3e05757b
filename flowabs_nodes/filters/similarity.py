"""Averages among similar colours (eqs. 12-14): what the flow-based and the oriented bilateral filters share.

Each pass is a weighted mean of readings along some line or curve through a pixel: weight alpha G(s) h, where G falls
with the distance s along the line and h, eq. 13, with the difference of colour from the pixel in the middle.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numba import prange

from flowabs_nodes.filters import arguments, gaussian
from flowabs_nodes.filters.arguments import Array
from flowabs_nodes.filters.blocks import Block, first_pixel, inline, scratch, u
from flowabs_nodes.filters.exponential import LOG2_E, exp2
from flowabs_nodes.filters.kernels import parallel_kernel

TINY = np.float32(1e-20)  # an alpha from which colours can no longer be told


def coverage(alpha: npt.ArrayLike | None, codes: Array) -> Array:
    """``alpha`` as (H, W), 1 everywhere where there is none."""
    if alpha is None:
        return np.broadcast_to(np.float32(1), codes.shape[:2])
    return arguments.plane("alpha", alpha, codes.shape)


def in_turn(codes: Array, alpha: Array, passes: list[Callable[[Array, Array], None]], iterations: int) -> Array:
    """``codes`` after each of the passes in turn, ``iterations`` times.

    A pass fills its second argument from the first. Pixels are (alpha L, alpha a, alpha b, alpha) there, so that
    bilinear readings mix colours by how much is there of each.
    """
    picture, smoothed = (np.empty((*codes.shape[:2], 4), np.float32) for _ in range(2))
    _multiply(codes, alpha, picture)
    for _ in range(iterations):
        for smooth in passes:
            smooth(picture, smoothed)
            picture, smoothed = smoothed, picture
    result = smoothed.reshape(-1)[: codes.size].reshape(codes.shape)  # its memory is free now
    _divide(picture, codes, result)
    return result


def closeness(sigma: float) -> Array:
    """log2 G(0), G(1) .. to one side, without the constant factor."""
    steps = np.arange(gaussian.radius(sigma) + 1)
    return (-LOG2_E / 2 * (steps / max(sigma, 1e-6)) ** 2).astype(np.float32)


def falloff(r: float) -> np.float32:
    """log2 h for a colour difference of 1 (eq. 13), without the constant factor."""
    return np.float32(max(-LOG2_E / 2 / r / r, -1e30))


@parallel_kernel
def _multiply(codes: Any, alpha: Any, picture: Any) -> None:
    height, width, _ = codes.shape
    for y in prange(height):
        for x in range(width):
            a = alpha[y, x] if alpha[y, x] > TINY else np.float32(0.0)
            picture[y, x, 0] = a * codes[y, x, 0]
            picture[y, x, 1] = a * codes[y, x, 1]
            picture[y, x, 2] = a * codes[y, x, 2]
            picture[y, x, 3] = a


@parallel_kernel
def _divide(picture: Any, codes: Any, result: Any) -> None:
    height, width, _ = codes.shape
    for y in prange(height):
        for x in range(width):
            a = picture[y, x, 3]
            for c in range(3):
                result[y, x, c] = picture[y, x, c] / a if a > 0 else codes[y, x, c]


class Sums(NamedTuple):
    """Of each pixel of a block: its colour, the weighted sum of differences from it, and the sum of weights.

    Sums of differences round less than sums of colours would, and constants stay exactly as they are.
    """

    l: Any  # noqa: E741
    a: Any
    b: Any
    dl: Any
    da: Any
    db: Any
    weight: Any


@inline
def new_sums() -> Sums:
    return Sums(
        scratch(np.float32, 1),
        scratch(np.float32, 1),
        scratch(np.float32, 1),
        scratch(np.float32, 1),
        scratch(np.float32, 1),
        scratch(np.float32, 1),
        scratch(np.float32, 1),
    )


@inline
def begin(sums: Sums, picture: Any, block: Block) -> None:
    """The centre counts with its own alpha; its difference is 0."""
    first = u(4) * first_pixel(block)
    for i in range(block.size):
        k = first + u(4) * i
        alpha = picture[k + u(3)]
        over = np.float32(1.0) / alpha if alpha > 0 else np.float32(0.0)
        sums.l[i] = over * picture[k]
        sums.a[i] = over * picture[k + u(1)]
        sums.b[i] = over * picture[k + u(2)]
        sums.dl[i] = np.float32(0.0)
        sums.da[i] = np.float32(0.0)
        sums.db[i] = np.float32(0.0)
        sums.weight[i] = alpha


@inline
def weigh(sums: Sums, values: Any, closeness: Any, falloff: Any, block: Block) -> None:
    """Add one reading for each pixel, weighted by alpha G h."""
    for i in range(block.size):
        k = u(4) * i
        alpha = values[k + u(3)]
        over = np.float32(1.0) / alpha if alpha > TINY else np.float32(0.0)
        dl = over * values[k] - sums.l[i]
        da = over * values[k + u(1)] - sums.a[i]
        db = over * values[k + u(2)] - sums.b[i]
        weight = alpha * exp2(closeness + falloff * (dl * dl + da * da + db * db))
        sums.dl[i] += weight * dl
        sums.da[i] += weight * da
        sums.db[i] += weight * db
        sums.weight[i] += weight


@inline
def finish(sums: Sums, picture: Any, smoothed: Any, block: Block) -> None:
    first = u(4) * first_pixel(block)
    for i in range(block.size):
        k = first + u(4) * i
        alpha = picture[k + u(3)]
        over = np.float32(1.0) / sums.weight[i] if alpha > 0 else np.float32(0.0)
        smoothed[k] = alpha * (sums.l[i] + over * sums.dl[i])
        smoothed[k + u(1)] = alpha * (sums.a[i] + over * sums.da[i])
        smoothed[k + u(2)] = alpha * (sums.b[i] + over * sums.db[i])
        smoothed[k + u(3)] = alpha
