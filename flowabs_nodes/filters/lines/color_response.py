"""The responses of lightness and of two channels of colour as one: H = M tanh(2 d_L), or with a sign of colour too.

What that sign is, :func:`~flowabs_nodes.filters.fdog` says under ``color_sign``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.simd.elementary import LOG2_E, exp2_of_negative
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import Floats, absolute, maximum, minimum, select, splat_floats, sqrt
from flowabs_nodes.simd.memory import load, store
from flowabs_nodes.simd.pixelwise import as_picture, as_run, empty_run, first_pixel, over_pixels

# Below the first of these |d_L| / m_c the sign of H is that of colour alone, above the second that of lightness alone.
_COLOR_ALONE, _LIGHTNESS_ALONE = 0.1, 0.3
# How light red (a) and yellow (b) count as where lightness decides nothing.
_DARK_A, _DARK_B = 0.4, 0.7
# In code values: from the first of these m_c on a side is dark unless it is clearly the light one, fully at the second.
_DARK_IN_DOUBT, _DARK_UNLESS_LIGHT = 1.0, 2.0


def joined_channels(responses: Array, color_weight: float, color_sign: bool) -> Array:
    """Return H, (H, W), of the channels' responses (C, H, W); with a ``color_weight`` of 0 that of the first alone."""
    if color_weight == 0:
        first: Array = responses[0]
        return first
    # A picture of one channel has no colour: the kernel gets its lightness three times, and reads it once.
    channels = [as_run(responses[min(c, len(responses) - 1)]) for c in range(3)]
    joined = empty_run(responses[0].size)
    rule = ColorRule(len(responses) > 1, np.float32(color_weight), color_sign)
    over_pixels(_join_channels, joined.size, *channels, rule, joined)
    return as_picture(joined, *responses.shape[1:])


class ColorRule(NamedTuple):
    """How the responses of colour join that of lightness."""

    is_color: bool  # whether there are any
    weight: np.float32
    color_sign: bool  # colour decides the sign where lightness has next to none


@kernel
def _join_channels(
    first: int,
    last: int,
    lightness: Array,
    a: Array,
    b: Array,
    rule: ColorRule,
    joined: Array,
) -> None:
    """Join the channels' responses to H = M tanh(2 d_L), M = sqrt(d_L^2 + w^2 (d_a^2 + d_b^2)), w being the weight.

    Writes the blocks ``first`` .. ``last`` - 1 of sixteen pixels.
    """
    is_color, weight, color_sign = rule
    for block in range(first, last):
        i = first_pixel(block, joined.size)
        d, da, db = load(lightness, i), splat_floats(0.0), splat_floats(0.0)
        if is_color:
            da, db = load(a, i) * weight, load(b, i) * weight
        sign = _tanh_of_twice(d)
        if is_color and color_sign:
            chroma, slight = sqrt(minimum(da * da + db * db, 3e38)), absolute(d)
            t = _smoothstep((slight / chroma - _COLOR_ALONE) / (_LIGHTNESS_ALONE - _COLOR_ALONE))
            t = select(chroma > 0.0, t, 1.0)
            sign = t * sign + (1.0 - t) * _tanh_of_twice(_DARK_A * da + _DARK_B * db)
            q = _smoothstep((chroma - _DARK_IN_DOUBT) / (_DARK_UNLESS_LIGHT - _DARK_IN_DOUBT))
            sign = sign + q * ((2.0 * _smoothstep(sign) - 1.0) - sign)
        store(joined, i, sign * sqrt(minimum(d * d + da * da + db * db, 3e38)))


@inlined
def _smoothstep(x: Floats) -> Floats:
    """Return smoothstep(0, 1, x): 3 x^2 - 2 x^3 between 0 and 1, constant beyond."""
    x = minimum(maximum(x, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


@inlined
def _tanh_of_twice(d: Floats) -> Floats:
    """Return tanh(2 d): tanh(2 |d|) = (1 - e) / (1 + e) with e = exp(-4 |d|)."""
    e = exp2_of_negative(absolute(d) * (-4 * LOG2_E))
    tanh = (1.0 - e) / (1.0 + e)
    return select(d < 0.0, -tanh, tanh)
