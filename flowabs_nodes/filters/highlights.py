"""A shoulder for highlights: light above a knee is compressed, so that none passes a limit, and keeps its hue."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import validate
from flowabs_nodes.simd.elementary import LOG2_E, exp2_of_negative
from flowabs_nodes.simd.finite import refuse_overflow
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import Floats, maximum, minimum, select, splat_floats
from flowabs_nodes.simd.memory import store_quads, store_triples
from flowabs_nodes.simd.pixelwise import any_nan, as_picture, as_run, empty_run, first_pixel, over_pixels, zero_or_nan
from flowabs_nodes.simd.premultiplied import TINY, load_rgba


def shoulder(image: npt.ArrayLike, knee: float = 0.6, headroom: float = 0.4, lift: float = 0.0) -> Array:
    """Compress light above a knee: m' = knee + headroom (1 - exp(-(m - knee) / headroom)), and RGB times m' / m.

    m is the largest of R, G, B, divided by alpha where that is above 0. What is at most the knee stays bit for bit, the
    slope at the knee is 1, and no channel of a finite colour passes knee + headroom + lift.

    Parameters
    ----------
    image
        Scene-linear, (H, W, 3), or premultiplied (H, W, 4), whose alpha stays.
    knee
        Light from which on it is compressed, at least 0.
    headroom
        How much light above the knee all highlights share, above 0.
    lift
        Light that is added last, 0 to 1e30, times alpha: under an encoding by stops, what is much darker than this no
        longer counts the more the darker it is.

    Returns
    -------
    The picture, float32, of the same shape. Negative channels are scaled with their pixel.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    image = validate.any_channels("image", image, check_finite=False)
    channels = image.shape[-1]
    if image.ndim != 3 or channels not in (3, 4):
        raise ArgumentError(f"image: expected shape (H, W, 3) or (H, W, 4), found {image.shape}", parameter="image")
    knee = validate.number("knee", knee, min=0, max=1e30)
    headroom = validate.number("headroom", headroom, above=0, max=1e30)
    lift = validate.number("lift", lift, min=0, max=1e30)
    run = as_run(image, channels)
    pixels = run.size // channels
    result = empty_run(pixels, channels)
    picture = as_picture(result, *image.shape)
    slope = np.float32(min(1 / headroom, 1e30))
    rule = np.float32(knee), np.float32(headroom), slope, np.float32(lift)
    if any(over_pixels(_compress, pixels, run, channels, *rule, result)):
        refuse_overflow("image", image, picture)
    return picture


@kernel
def _compress(
    first: int,
    last: int,
    image: Array,
    channels: int,
    knee: float,
    headroom: float,
    slope: float,
    lift: float,
    result: Array,
) -> Any:
    """Write the blocks ``first`` .. ``last`` - 1 of sixteen pixels; return whether one is not finite.

    ``slope`` is 1 / ``headroom``.
    """
    total, pixels = splat_floats(0.0), image.size // channels
    for block in range(first, last):
        i = first_pixel(block, pixels)
        r, g, b, a = load_rgba(image, channels, i)
        largest = maximum(maximum(r, g), b)
        light = minimum(select(a > TINY, largest / a, largest), 3e38)
        compressed = knee + headroom * _rise((light - knee) * slope)
        gain = select(light > knee, compressed / light, splat_floats(1.0))
        total = total + (zero_or_nan(r) + zero_or_nan(g) + zero_or_nan(b))
        r, g, b = r * gain, g * gain, b * gain
        if lift > 0:
            lifted = lift * maximum(a, 0.0)
            r, g, b = r + lifted, g + lifted, b + lifted
        if channels == 4:
            store_quads(result, 4 * i, (r, g, b, a))
        else:
            store_triples(result, 3 * i, (r, g, b))
    return any_nan(total)


@inlined
def _rise(x: Floats) -> Floats:
    """Return 1 - exp(-x), of x up to 1/4 by its series, as a difference of two numbers near 1 has few digits."""
    series = x * (1.0 - x * (1 / 2 - x * (1 / 6 - x * (1 / 24 - x * (1 / 120 - x * (1 / 720))))))
    return select(x > 0.25, 1.0 - exp2_of_negative(x * -LOG2_E), series)
