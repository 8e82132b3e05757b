"""Pictures as one run of pixels, for kernels in which each pixel is on its own: rows do not matter there.

Such a kernel is called with the numbers of its first and last blocks of sixteen pixels: ``for block in range(first,
last)``, the pixels from ``first_of(block, pixels)`` on. The last block overlaps the one before it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined
from flowabs_nodes.simd.lanes import LANES, any_lane, bits_of

_LEAST = 256  # blocks in a band


def as_run(picture: Array, channels: int = 1) -> Array:
    """All numbers of a picture, (pixels x channels,); a picture of fewer than sixteen pixels is repeated."""
    run = picture.reshape(-1)
    return run if run.size >= LANES * channels else np.resize(run, LANES * channels)


def empty_run(pixels: int, channels: int = 1) -> Array:
    """As :func:`as_run`, not filled."""
    return np.empty(max(pixels, LANES) * channels, np.float32)


def as_picture(run: Array, *shape: int) -> Array:
    """A run as a picture again."""
    size = int(np.prod(shape))
    return run[:size].reshape(shape) if run.size > size else run.reshape(shape)


def over_pixels(kernel: Callable[..., Any], pixels: int, *arguments: Any) -> list[Any]:
    """``kernel(first, last, *arguments)`` for bands that together are all pixels; what it returned."""
    return over_rows(kernel, -(-pixels // LANES), *arguments, least=_LEAST)


@inlined
def first_pixel(block: int, pixels: int) -> int:
    """The first of a block's sixteen pixels."""
    return min(LANES * block, pixels - LANES)


@inlined
def zero_or_nan(x: Any) -> Any:
    """0 for a finite number, else NaN: sums of it stay NaN."""
    return x - x


@inlined
def any_nan(x: Any) -> Any:
    """Whether any lane is NaN, of a vector whose others are 0."""
    return any_lane((bits_of(x) & 0x7FFFFFFF) > 0)
