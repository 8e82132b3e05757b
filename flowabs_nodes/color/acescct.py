"""ACEScct (Academy S-2016-001) of each channel in AP1, in code values, x 255 / ACEScct(1): kernels.

Pictures are runs of pixels (:mod:`~flowabs_nodes.simd.pixelwise`); what is not wanted, or not there, is a run of no
pixels. Each kernel returns whether there is a number that is not finite.
"""

from __future__ import annotations

from typing import Any

from flowabs_nodes.color import constants
from flowabs_nodes.simd.elementary import exp2, log2
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import select, splat_floats
from flowabs_nodes.simd.matrix3 import Rows, mix, mix_second_row
from flowabs_nodes.simd.memory import load_triples, store, store_triples
from flowabs_nodes.simd.pixelwise import any_nan, first_pixel, zero_or_nan
from flowabs_nodes.simd.premultiplied import load_rgb_over_ground, store_over

UNIT = 255 / constants.ACESCCT_WHITE  # code values of ACEScct 1.0
X_BREAK = constants.ACESCCT_X_BRK
Y_BREAK = constants.ACESCCT_Y_BRK * UNIT
TOE_SLOPE = constants.ACESCCT_A * UNIT
TOE_OFFSET = constants.ACESCCT_B * UNIT
PER_STOP = UNIT / constants.ACESCCT_SCALE
WHITE = 255.0


@inlined
def _code(x: Any) -> Any:
    # (log2 x + 9.72) / 17.52 of the standard, counted from white: exact there, and as exact near it as float32 is.
    return select(x > X_BREAK, WHITE + PER_STOP * log2(x), TOE_OFFSET + TOE_SLOPE * x)


@inlined
def _linear(code: Any) -> Any:
    return select(code > Y_BREAK, exp2((code - WHITE) * (1 / PER_STOP)), (code - TOE_OFFSET) * (1 / TOE_SLOPE))


@kernel
def encode(
    first: int,
    last: int,
    pixels: Any,
    channels: int,
    ground: float,
    to_ap1: Rows,
    to_luminance: Rows,
    codes: Any,
    mono: Any,
) -> Any:
    """What is seen of a picture (``premultiplied.seen``) as ACEScct of R, G, B, and of its AP1 luminance.

    That is the second row of ``to_luminance``.
    """
    total, count = splat_floats(0.0), pixels.size // channels
    for block in range(first, last):
        i = first_pixel(block, count)
        r, g, b = load_rgb_over_ground(pixels, channels, ground, i)
        total = total + (zero_or_nan(r) + zero_or_nan(g) + zero_or_nan(b))
        if mono.size > 0:
            store(mono, i, _code(mix_second_row(to_luminance, r, g, b)))
        if codes.size > 0:
            r, g, b = mix(to_ap1, r, g, b)
            store_triples(codes, 3 * i, (_code(r), _code(g), _code(b)))
    return any_nan(total)


@kernel
def decode(first: int, last: int, codes: Any, from_ap1: Rows, under: Any, pixels: Any) -> Any:
    """Turn ACEScct into scene-linear RGB, with the alpha of the picture ``under`` it if there is one."""
    total, count = splat_floats(0.0), codes.size // 3
    for block in range(first, last):
        i = first_pixel(block, count)
        r, g, b = load_triples(codes, 3 * i)
        total = total + (zero_or_nan(r) + zero_or_nan(g) + zero_or_nan(b))
        store_over(to_rgb(r, g, b, from_ap1), under, pixels, i)
    return any_nan(total)


@inlined
def to_rgb(r: Any, g: Any, b: Any, from_ap1: Rows) -> Any:
    """Return red, green and blue of code values."""
    return mix(from_ap1, _linear(r), _linear(g), _linear(b))
