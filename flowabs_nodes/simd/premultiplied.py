"""Reading and writing sixteen pixels of a picture with or without alpha: what kernels of colours share."""

from __future__ import annotations

from typing import Any

from flowabs_nodes.simd.jit import inlined
from flowabs_nodes.simd.lanes import absolute, select, splat_floats
from flowabs_nodes.simd.memory import load_quads, load_triples, store_quads, store_triples


@inlined
def load_rgba(pixels: Any, channels: int, i: Any) -> Any:
    """Premultiplied red, green, blue and alpha of the pixels from the i-th on; alpha is 1 of three channels."""
    if channels == 4:
        return load_quads(pixels, 4 * i)
    r, g, b = load_triples(pixels, 3 * i)
    return r, g, b, splat_floats(1.0)


@inlined
def load_rgb_over_ground(pixels: Any, channels: int, ground: float, i: Any) -> Any:
    """rgb + (1 - A) ground; with a ground of less than 0 rgb / A, 0 where A is."""
    r, g, b, a = load_rgba(pixels, channels, i)
    if channels == 4:
        if ground < 0:
            there, nothing = a > 0.0, splat_floats(0.0)
            r, g, b = select(there, r / a, nothing), select(there, g / a, nothing), select(there, b / a, nothing)
        else:
            behind = (1.0 - a) * ground
            r, g, b = r + behind, g + behind, b + behind
    return r, g, b


@inlined
def premultiplied_over(r: Any, g: Any, b: Any, under: Any, i: Any) -> Any:
    """Premultiplied RGBA with the alpha of the picture under them, premultiplied RGBA, which stays where nothing is."""
    red, green, blue, a = load_quads(under, 4 * i)
    there = absolute(a) > 0.0
    return select(there, r * a, red), select(there, g * a, green), select(there, b * a, blue), a


@inlined
def store_over(rgb: Any, under: Any, pixels: Any, i: Any) -> None:
    """Write red, green and blue as the pixels from the i-th on, premultiplied if there is a picture ``under`` them."""
    r, g, b = rgb
    if under.size > 0:
        store_quads(pixels, 4 * i, premultiplied_over(r, g, b, under, i))
    else:
        store_triples(pixels, 3 * i, (r, g, b))
