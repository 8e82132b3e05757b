"""Compiled kernels of ACEScct (Academy S-2016-001) in code values: ACEScct of each AP1 channel, x 255 / ACEScct(1).

The kernels take pictures as runs of pixels (:mod:`~flowabs_nodes.simd.pixelwise`), and a run of no pixels for a result
that is not wanted or a picture that there is not. ``first`` and ``last`` bound blocks of sixteen pixels. Each kernel
returns whether it met a number that is not finite, or made one.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from flowabs_nodes.array_types import Array
from flowabs_nodes.color import constants
from flowabs_nodes.simd.elementary import exp2, log2
from flowabs_nodes.simd.finite import zero_if_summable
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import select, splat_floats
from flowabs_nodes.simd.matrix3 import Rows, mix, mix_second_row
from flowabs_nodes.simd.memory import load_triples, store, store_triples
from flowabs_nodes.simd.pixelwise import any_nan, first_pixel, zero_or_nan
from flowabs_nodes.simd.premultiplied import load_rgb_over_ground, store_over

UNIT = 255 / constants.ACESCCT_WHITE  # code values per unit of ACEScct
X_BREAK = constants.ACESCCT_X_BRK
Y_BREAK = constants.ACESCCT_Y_BRK * UNIT
TOE_SLOPE = constants.ACESCCT_A * UNIT
TOE_OFFSET = constants.ACESCCT_B * UNIT
PER_STOP = UNIT / constants.ACESCCT_SCALE
WHITE = 255.0


class ToAp1(NamedTuple):
    """Matrices from the RGB of a colour space."""

    channels: Rows  # to AP1, white adapted
    luminance: Rows  # to XYZ over the white, by way of AP1: the second row gives the AP1 luminance


@inlined
def _code(x: Any) -> Any:
    """Return the code values of sixteen linear AP1 values."""
    # (log2 x + 9.72) / 17.52 of the standard, counted from white: exact there, and as exact near white as float32 is.
    return select(x > X_BREAK, WHITE + PER_STOP * log2(x), TOE_OFFSET + TOE_SLOPE * x)


@inlined
def _linear(code: Any) -> Any:
    """Return the linear AP1 values of sixteen code values: the inverse of :func:`_code`."""
    return select(code > Y_BREAK, exp2((code - WHITE) * (1 / PER_STOP)), (code - TOE_OFFSET) * (1 / TOE_SLOPE))


@kernel
def encode(
    first: int,
    last: int,
    pixels: Array,
    channels: int,
    ground: float,
    to_ap1: ToAp1,
    opponent: bool,
    codes: Array,
    mono: Array,
) -> Any:
    """Encode a picture over its ground: its AP1 channels to ``codes``, its AP1 luminance to ``mono``.

    ``pixels`` is (pixels x channels,) scene-linear; ``ground`` is what
    :func:`~flowabs_nodes.simd.premultiplied.load_rgb_over_ground` takes. With ``opponent``, the luminance goes to
    ``codes`` as well, with red and blue less it in place of the channels.
    """
    total, count = splat_floats(0.0), pixels.size // channels
    for block in range(first, last):
        i = first_pixel(block, count)
        r, g, b = load_rgb_over_ground(pixels, channels, ground, i)
        total = total + zero_or_nan(r + (g + b))
        lightness = splat_floats(0.0)
        if mono.size > 0 or opponent:
            lightness = _code(mix_second_row(to_ap1.luminance, r, g, b))
            total = total + zero_if_summable(lightness)
        if mono.size > 0:
            store(mono, i, lightness)
        if codes.size > 0:
            r, g, b = mix(to_ap1.channels, r, g, b)
            r, g, b = _code(r), _code(g), _code(b)
            if opponent:
                r, g, b = lightness, r - lightness, b - lightness
            total = total + zero_if_summable(r + (g + b))
            store_triples(codes, 3 * i, (r, g, b))
    return any_nan(total)


@kernel
def decode(first: int, last: int, codes: Array, from_ap1: Rows, under: Array, pixels: Array) -> Any:
    """Decode ACEScct to scene-linear RGB; with a picture ``under`` it, to RGBA premultiplied by its alpha."""
    total, count = splat_floats(0.0), codes.size // 3
    for block in range(first, last):
        i = first_pixel(block, count)
        r, g, b = load_triples(codes, 3 * i)
        total = total + (zero_or_nan(r) + zero_or_nan(g) + zero_or_nan(b))
        red, green, blue = store_over(to_rgb(r, g, b, from_ap1), under, pixels, i)
        total = total + (zero_or_nan(red) + zero_or_nan(green) + zero_or_nan(blue))
    return any_nan(total)


@inlined
def to_rgb(r: Any, g: Any, b: Any, from_ap1: Rows) -> Any:
    """Return red, green and blue of sixteen pixels of code values."""
    return mix(from_ap1, _linear(r), _linear(g), _linear(b))
