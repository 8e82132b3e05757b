"""Compiled kernels of CIE 1976 L*a*b* (CIE 15:2004) in code values: L*, a*, b* times 2.55.

The kernels work with g = f - 16/116 instead of CIE's f: then L* = 116 g(Y), the toe is g = kappa/116 x without an
offset to cancel against, and black, tiny and negative values keep all their digits.

They take pictures as runs of pixels (:mod:`~flowabs_nodes.simd.pixelwise`), and a run of no pixels for a result that is
not wanted or a picture that there is not. ``first`` and ``last`` bound blocks of sixteen pixels. Each kernel returns
whether it met a number that is not finite, or made one. Matrices from and to XYZ are over the white of the space.
"""

from __future__ import annotations

from typing import Any

from flowabs_nodes.array_types import Array
from flowabs_nodes.color import constants
from flowabs_nodes.simd.elementary import cube_root
from flowabs_nodes.simd.finite import zero_if_summable
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import select, splat_floats
from flowabs_nodes.simd.matrix3 import Rows, mix, mix_second_row
from flowabs_nodes.simd.memory import load_triples, store, store_triples
from flowabs_nodes.simd.pixelwise import any_nan, first_pixel, zero_or_nan
from flowabs_nodes.simd.premultiplied import load_rgb_over_ground, store_over

EPSILON = constants.LAB_EPSILON
SLOPE = constants.LAB_KAPPA / 116
OFFSET = 16 / 116
G_EPSILON = 6 / 29 - 16 / 116  # g(EPSILON)
L = 2.55 * 116  # code values per unit of g: L* = 116 g(Y), a* = 500 (g(X) - g(Y)), b* = 200 (g(Y) - g(Z))
A = 2.55 * 500
B = 2.55 * 200


@inlined
def g_of(x: Any) -> Any:
    """Return g = f(x) - 16/116 of sixteen values of X, Y or Z over the white's."""
    return select(x > EPSILON, cube_root(x) - OFFSET, SLOPE * x)


@inlined
def g_inverse(g: Any) -> Any:
    """Return X, Y or Z over the white's: the inverse of :func:`g_of`."""
    f = g + OFFSET
    return select(g > G_EPSILON, f * f * f, g * (1 / SLOPE))


@kernel
def encode(
    first: int, last: int, pixels: Array, channels: int, ground: float, to_xyz: Rows, codes: Array, mono: Array
) -> Any:
    """Encode a picture over its ground: L*, a*, b* to ``codes``, L* alone to ``mono``.

    ``pixels`` is (pixels x channels,) scene-linear; ``ground`` is what
    :func:`~flowabs_nodes.simd.premultiplied.load_rgb_over_ground` takes.
    """
    total, count = splat_floats(0.0), pixels.size // channels
    for block in range(first, last):
        i = first_pixel(block, count)
        r, g, b = load_rgb_over_ground(pixels, channels, ground, i)
        gy = g_of(mix_second_row(to_xyz, r, g, b))  # not finite if a channel is not: the cube root keeps Inf and NaN
        lightness = L * gy
        if mono.size > 0:
            total = total + zero_if_summable(lightness)
            store(mono, i, lightness)
        if codes.size > 0:
            x, _, z = mix(to_xyz, r, g, b)
            a_star, b_star = A * (g_of(x) - gy), B * (gy - g_of(z))
            total = total + zero_if_summable(lightness + (a_star + b_star))
            store_triples(codes, 3 * i, (lightness, a_star, b_star))
    return any_nan(total)


@kernel
def decode(first: int, last: int, codes: Array, from_xyz: Rows, under: Array, pixels: Array) -> Any:
    """Decode L*, a*, b* to scene-linear RGB; with a picture ``under`` them, to RGBA premultiplied by its alpha."""
    total, count = splat_floats(0.0), codes.size // 3
    for block in range(first, last):
        i = first_pixel(block, count)
        lightness, a, b = load_triples(codes, 3 * i)
        red, green, blue = store_over(to_rgb(lightness, a, b, from_xyz), under, pixels, i)
        total = total + (zero_or_nan(red) + zero_or_nan(green) + zero_or_nan(blue))
    return any_nan(total)


@inlined
def to_rgb(lightness: Any, a: Any, b: Any, from_xyz: Rows) -> Any:
    """Return red, green and blue of sixteen pixels of code values L*, a*, b*."""
    gy = lightness * (1 / L)
    return mix(from_xyz, g_inverse(gy + a * (1 / A)), g_inverse(gy), g_inverse(gy - b * (1 / B)))
