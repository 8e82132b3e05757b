"""Reading and writing sixteen pixels of a picture with or without alpha, for the kernels that convert colours.

Pictures are (H, W, 3), or (H, W, 4) with colours premultiplied by alpha, flattened to 1-D float32 arrays.
"""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.simd.jit import inlined
from flowabs_nodes.simd.lanes import Floats, select, splat_floats
from flowabs_nodes.simd.memory import load_quads, load_triples, store_quads, store_triples

#: Alpha up to which a pixel is not covered: a colour divided by less would leave float32.
TINY = np.float32(1e-20)


@inlined
def load_rgba(pixels: Array, channels: int, i: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Return premultiplied red, green, blue and alpha of the sixteen pixels from pixel i on.

    ``channels`` is that of ``pixels``, 3 or 4; with three, alpha is 1.
    """
    if channels == 4:
        r, g, b, a = load_quads(pixels, 4 * i)
        return r, g, b, a
    r, g, b = load_triples(pixels, 3 * i)
    return r, g, b, splat_floats(1.0)


@inlined
def load_rgb_over_ground(pixels: Array, channels: int, ground: float, i: int) -> tuple[Floats, Floats, Floats]:
    """Return red, green and blue of the sixteen pixels from pixel i on, composited over a grey ``ground``.

    The result is rgb + (1 - alpha) ground. A ``ground`` below 0 stands for none: the result is then rgb / alpha, the
    colour without premultiplication, and 0 where alpha is not above ``TINY``.
    """
    r, g, b, a = load_rgba(pixels, channels, i)
    if channels == 4:
        if ground < 0:
            covered, zero = a > TINY, splat_floats(0.0)
            r, g, b = select(covered, r / a, zero), select(covered, g / a, zero), select(covered, b / a, zero)
        else:
            behind = (1.0 - a) * ground
            r, g, b = r + behind, g + behind, b + behind
    return r, g, b


@inlined
def premultiplied_over(r: Floats, g: Floats, b: Floats, under: Array, i: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the colours r, g, b premultiplied by the alpha of the sixteen pixels of ``under`` from pixel i on.

    ``under`` is premultiplied (H, W, 4), flattened. The result is red, green, blue and alpha. Where the alpha is
    not above ``TINY``, it is the pixel of ``under`` unchanged.
    """
    red, green, blue, a = load_quads(under, 4 * i)
    covered = a > TINY
    return select(covered, r * a, red), select(covered, g * a, green), select(covered, b * a, blue), a


@inlined
def store_over(
    rgb: tuple[Floats, Floats, Floats], under: Array, pixels: Array, i: int
) -> tuple[Floats, Floats, Floats]:
    """Write red, green and blue to the sixteen pixels of ``pixels`` from pixel i on, and return what was written.

    If ``under`` is empty, ``pixels`` has three channels. Otherwise it has four, written by :func:`premultiplied_over`.
    """
    r, g, b = rgb
    if under.size > 0:
        r, g, b, a = premultiplied_over(r, g, b, under, i)
        store_quads(pixels, 4 * i, (r, g, b, a))
    else:
        store_triples(pixels, 3 * i, (r, g, b))
    return r, g, b
