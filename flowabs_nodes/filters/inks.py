"""Choose the colour of ink by what it lies on: a darker shade of it, or a light ink on dark grounds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import validate
from flowabs_nodes.simd.finite import refuse_non_finite, refuse_overflow
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import Floats, maximum, minimum, splat_floats
from flowabs_nodes.simd.memory import load, load_triples, store_triples
from flowabs_nodes.simd.pixelwise import any_nan, as_picture, as_run, empty_run, first_pixel, over_pixels, zero_or_nan

#: The light of toned ink, as a part of that of what it lies on: three stops less.
SHADE = np.float32(1 / 8)

# Of light_below: up to the first lightness ink is light, from the second on it is dark.
_LIGHT, _DARK = 0.75, 1.25


class Inks(NamedTuple):
    """A kernel's view of the parameters of :func:`ink_color`."""

    ink: tuple[float, float, float]
    tone: np.float32
    light_ink: tuple[float, float, float]
    light_below: np.float32


def ink_color(
    rgb: npt.ArrayLike,
    lightness: npt.ArrayLike,
    ink: Sequence[float] = (0.0, 0.0, 0.0),
    tone: float = 0.0,
    light_ink: Sequence[float] = (0.8, 0.8, 0.8),
    light_below: float = 0.0,
) -> Array:
    """Return the colour of ink at each pixel: c = d + l (light_ink - d), d = ink + tone (f / 8 - ink).

    f = rgb / max(1, its largest channel): on light beyond white, ink is as on white, or a screen would show none.
    l = 1 - smoothstep(3/4, 5/4, lightness / light_below) is 1 on dark grounds, and 0 where ``light_below`` is 0.

    Parameters
    ----------
    rgb
        What the ink lies on, (H, W, 3), scene-linear, not premultiplied; channels below 0 count as 0.
    lightness
        Its lightness, (H, W), in any scale.
    ink
        The ink, three numbers, in the colours of ``rgb``.
    tone
        0 to 1: how far ink is a shade of what it lies on, of its hue, at an eighth of its light, rather than ``ink``.
    light_ink
        The ink on dark grounds, three numbers.
    light_below
        The lightness below which grounds are dark, in the scale of ``lightness``, at least 0.

    Returns
    -------
    (H, W, 3) float32, to give to :func:`~flowabs_nodes.filters.composite` as its ink.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    rgb = validate.planes("rgb", rgb, check_finite=False)
    lightness = validate.plane("lightness", lightness, rgb.shape)
    inks = Inks(
        _three("ink", ink),
        np.float32(validate.number("tone", tone, min=0, max=1)),
        _three("light_ink", light_ink),
        np.float32(validate.number("light_below", light_below, min=0, max=1e6)),
    )
    colors = empty_run(lightness.size, 3)
    if any(over_pixels(_ink_color, max(lightness.size, 16), as_run(rgb, 3), as_run(lightness), inks, colors)):
        refuse_non_finite("rgb", rgb)
        refuse_overflow("rgb", rgb, as_picture(colors, *rgb.shape))
    return as_picture(colors, *rgb.shape)


def _three(name: str, values: Sequence[float]) -> tuple[float, float, float]:
    """Return a colour as three finite floats."""
    color = [validate.number(name, value) for value in values]
    if len(color) != 3:
        raise ArgumentError(f"{name}: expected three numbers, found {len(color)}", parameter=name)
    return color[0], color[1], color[2]


@kernel
def _ink_color(first: int, last: int, rgb: Array, lightness: Array, inks: Inks, colors: Array) -> Any:
    """Write the blocks ``first`` .. ``last`` - 1 of sixteen pixels; return whether a number is not finite."""
    total = splat_floats(0.0)
    for block in range(first, last):
        i = first_pixel(block, lightness.size)
        r, g, b = load_triples(rgb, 3 * i)
        light = splat_floats(0.0)
        if inks.light_below > 0:
            x = load(lightness, i) / inks.light_below
            t = minimum(maximum((x - _LIGHT) / (_DARK - _LIGHT), 0.0), 1.0)
            light = 1.0 - t * t * (3.0 - 2.0 * t)
        most = maximum(maximum(r, g), maximum(b, 1.0))
        red = _mixed(r / most, inks.ink[0], inks.light_ink[0], inks.tone, light)
        green = _mixed(g / most, inks.ink[1], inks.light_ink[1], inks.tone, light)
        blue = _mixed(b / most, inks.ink[2], inks.light_ink[2], inks.tone, light)
        total = total + (zero_or_nan(r) + zero_or_nan(g) + zero_or_nan(b))
        total = total + (zero_or_nan(red) + zero_or_nan(green) + zero_or_nan(blue))
        store_triples(colors, 3 * i, (red, green, blue))
    return any_nan(total)


@inlined
def _mixed(ground: Floats, ink: float, light_ink: float, tone: float, light: Floats) -> Floats:
    """Return one channel of the ink's colour; ``light`` is l."""
    dark = ink + tone * (maximum(ground, 0.0) * SHADE - ink)
    return dark + light * (light_ink - dark)
