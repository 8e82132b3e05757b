"""CIE 1976 L*a*b* (CIE 15:2004) in code values, x 2.55: kernels.

The kernels work with g = f - 16/116 instead of CIE's f: then L* = 116 g(Y), the toe is g = kappa/116 x without an
offset to cancel against, and black, tiny and negative values keep all their digits.

Pictures are runs of pixels (:mod:`~flowabs_nodes.simd.pixelwise`); what is not wanted, or not there, is a run of no
pixels. Each kernel returns whether there is a number that is not finite.
"""

from __future__ import annotations

from typing import Any

from flowabs_nodes.color import constants
from flowabs_nodes.filters.compositing import over
from flowabs_nodes.filters.regions.quantize import Steps, middle
from flowabs_nodes.simd.elementary import cube_root
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import absolute, maximum, same_floats, select
from flowabs_nodes.simd.matrix3 import Rows, mix, second
from flowabs_nodes.simd.memory import load, load_triples, store, store_quads, store_triples
from flowabs_nodes.simd.pixelwise import doubt, doubtful, first_of
from flowabs_nodes.simd.premultiplied import covering, rgba, seen

EPSILON = constants.LAB_EPSILON
SLOPE = constants.LAB_KAPPA / 116
OFFSET = 16 / 116
G_EPSILON = 6 / 29 - 16 / 116  # g(EPSILON)
L = 2.55 * 116
A = 2.55 * 500
B = 2.55 * 200


@inlined
def _g(x: Any) -> Any:
    return select(x > EPSILON, cube_root(x) - OFFSET, SLOPE * x)


@inlined
def _g_inverse(g: Any) -> Any:
    f = g + OFFSET
    return select(g > G_EPSILON, f * f * f, g * (1 / SLOPE))


@inlined
def _gain(gy: Any, steps: Steps) -> Any:
    """Y(Q) / Y(L*), L* = 116 g, L* at least 1."""
    lightness = 116.0 * gy
    return _g_inverse(middle(lightness, steps) * (1 / 116)) / _g_inverse(maximum(lightness, 1.0) * (1 / 116))


@kernel
def encode(
    first: int, last: int, pixels: Any, channels: int, ground: float, to_xyz: Rows, codes: Any, mono: Any
) -> Any:
    """What is :func:`~flowabs_nodes.simd.premultiplied.seen` of a picture as L*, a*, b*, and as L* alone.

    ``to_xyz`` is over the white.
    """
    total, count = same_floats(0.0), pixels.size // channels
    for block in range(first, last):
        i = first_of(block, count)
        r, g, b = seen(pixels, channels, ground, i)
        total = total + (doubt(r) + doubt(g) + doubt(b))
        gy = _g(second(to_xyz, r, g, b))
        if mono.size > 0:
            store(mono, i, L * gy)
        if codes.size > 0:
            x, _, z = mix(to_xyz, r, g, b)
            store_triples(codes, 3 * i, (L * gy, A * (_g(x) - gy), B * (gy - _g(z))))
    return doubtful(total)


@kernel
def decode(
    first: int, last: int, codes: Any, from_xyz: Rows, steps: Steps, under: Any, lines: Any, ink: Any, pixels: Any
) -> Any:
    """L*, a*, b* to scene-linear RGB; ``from_xyz`` is over the white.

    On the way L* is brought to its step by a gain on RGB (section 4.1), unless there are 0 per L*; then comes alpha, if
    there is a picture ``under`` it, and ink, if there are ``lines``.
    """
    total, count = same_floats(0.0), codes.size // 3
    for block in range(first, last):
        i = first_of(block, count)
        lightness, a, b = load_triples(codes, 3 * i)
        total = total + (doubt(lightness) + doubt(a) + doubt(b))
        gy = lightness * (1 / L)
        x, y, z = _g_inverse(gy + a * (1 / A)), _g_inverse(gy), _g_inverse(gy - b * (1 / B))
        red, green, blue = mix(from_xyz, x, y, z)
        if steps[0] > 0:
            gain = _gain(gy, steps)
            red, green, blue = red * gain, green * gain, blue * gain
        alpha = same_floats(1.0)
        if under.size > 0:
            red, green, blue, alpha = covering(red, green, blue, under, i)
        if lines.size > 0:
            red, green, blue = over(red, green, blue, alpha, load(lines, i), ink)
        if under.size > 0:
            store_quads(pixels, 4 * i, (red, green, blue, alpha))
        else:
            store_triples(pixels, 3 * i, (red, green, blue))
    return doubtful(total)


@kernel
def flatten(first: int, last: int, pixels: Any, channels: int, to_xyz: Rows, steps: Steps, flat: Any) -> Any:
    """A picture with L* brought to its step, by a gain on scene-linear RGB (section 4.1); alpha as it was."""
    total, count = same_floats(0.0), pixels.size // channels
    for block in range(first, last):
        i = first_of(block, count)
        r, g, b = seen(pixels, channels, -1.0, i)
        total = total + (doubt(r) + doubt(g) + doubt(b))
        gain = _gain(_g(second(to_xyz, r, g, b)), steps)
        r, g, b, a = rgba(pixels, channels, i)
        gain = select(absolute(a) > 0.0, gain, same_floats(1.0))
        if channels == 4:
            store_quads(flat, 4 * i, (r * gain, g * gain, b * gain, a))
        else:
            store_triples(flat, 3 * i, (r * gain, g * gain, b * gain))
    return doubtful(total)
