"""Pictures as one run of pixels, for kernels that compute each pixel on its own, whatever its row.

Such a kernel works on blocks of sixteen pixels, ``for block in range(first, last)``, each from the pixel
``first_pixel(block, pixels)`` on. The last block of a picture overlaps the one before it where the pixels are not a
multiple of sixteen.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined
from flowabs_nodes.simd.lanes import LANES, Floats, any_lane, bits_of

_LEAST = 256  # blocks in a band at least: a shorter one is not worth another thread
_MOST = 2**13  # and at most: work that is asked to stop ends with the band


def as_run(picture: Array, channels: int = 1) -> Array:
    """Return the pixels of a C-contiguous ``picture`` of any shape as a 1-D array of pixels x ``channels`` numbers.

    The array shares the picture's memory, except that fewer than sixteen pixels are copied and repeated to sixteen.
    """
    run = picture.reshape(-1)
    return run if run.size >= LANES * channels else np.resize(run, LANES * channels)


def empty_run(pixels: int, channels: int = 1) -> Array:
    """Return an uninitialised float32 array for the run of a picture, of at least sixteen pixels."""
    return np.empty(max(pixels, LANES) * channels, np.float32)


def as_picture(run: Array, *shape: int) -> Array:
    """Return a run as a picture of the given ``shape``, without the pixels that filled it up to sixteen."""
    size = int(np.prod(shape))
    return run[:size].reshape(shape) if run.size > size else run.reshape(shape)


def over_pixels(kernel: Callable[..., Any], pixels: int, *arguments: Any) -> list[Any]:
    """Call ``kernel(first, last, *arguments)`` for ranges of blocks that together are all ``pixels``, by threads.

    Returns a list of the kernel's results, one for each range (:func:`~flowabs_nodes.simd.bands.over_rows`).
    """
    return over_rows(kernel, -(-pixels // LANES), *arguments, least=_LEAST, most=_MOST)


@inlined
def first_pixel(block: int, pixels: int) -> int:
    """Return the index of the first of the sixteen pixels of ``block``, in a run of ``pixels`` pixels."""
    return min(LANES * block, pixels - LANES)


@inlined
def zero_or_nan(x: Floats) -> Floats:
    """Return 0 where x is finite and NaN where it is not. A sum of many of these is NaN if one is."""
    return x - x


@inlined
def any_nan(x: Floats) -> bool:
    """Return whether any lane is NaN, for a vector whose lanes are NaN or 0."""
    found: bool = any_lane((bits_of(x) & 0x7FFFFFFF) > 0)  # -0 counts as 0
    return found
