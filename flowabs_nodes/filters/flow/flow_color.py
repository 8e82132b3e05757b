"""Orientations of a flow as RGB, as in the paper's Fig. 5."""

from __future__ import annotations

import math

import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters import validate
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.lanes import from_doubles, maximum, to_doubles
from flowabs_nodes.simd.memory import load_pairs, store_triples
from flowabs_nodes.simd.pixelwise import as_picture, as_run, empty_run, first_pixel, over_pixels

_HALF_ROOT_3 = math.sqrt(3) / 2


def flow_color(flow: npt.ArrayLike) -> Array:
    """Return a colour for each orientation, for comparing flows by eye or by number (Fig. 5).

    A tangent at angle θ (x right, y down) becomes ½ + ½ cos(2θ - φ) with φ = 0°, 120°, 240° for R, G, B. Opposite
    tangents are one orientation and one colour; turning by δ moves the colour by √(3/2) |sin δ| wherever it starts.

    Parameters
    ----------
    flow
        Tangents (H, W, 2), x then y. Longer ones count as unit vectors, shorter ones fade to grey.

    Returns
    -------
    RGB (H, W, 3) in [0, 1]: horizontal (1, ¼, ¼), vertical (0, ¾, ¾), zero tangents (½, ½, ½).

    Raises
    ------
    ArgumentError
        For another shape or dtype, or values that are not finite.
    """
    flow = validate.flow_field(flow)
    height, width, _ = flow.shape
    pixels = height * width
    rgb = empty_run(pixels, 3)
    over_pixels(_color, pixels, as_run(flow, 2), rgb)
    return as_picture(rgb, height, width, 3)


@kernel
def _color(first: int, last: int, flow: Array, rgb: Array) -> None:
    """Write the RGB (pixels, 3) of a flow (pixels, 2), flattened: the blocks of sixteen ``first`` .. ``last`` - 1."""
    for block in range(first, last):
        pixel = first_pixel(block, rgb.size // 3)
        x, y = load_pairs(flow, 2 * pixel)
        tx, ty = to_doubles(x), to_doubles(y)
        norm = 2.0 * maximum(tx * tx + ty * ty, 1.0)
        c, s = (tx * tx - ty * ty) / norm, 2.0 * tx * ty / norm  # half of cos 2θ and sin 2θ
        green, blue = 0.5 - 0.5 * c + _HALF_ROOT_3 * s, 0.5 - 0.5 * c - _HALF_ROOT_3 * s
        store_triples(rgb, 3 * pixel, (from_doubles(0.5 + c), from_doubles(green), from_doubles(blue)))
