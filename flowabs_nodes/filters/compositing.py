"""Lines laid over a picture in any ink."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import validate
from flowabs_nodes.simd.finite import refuse_non_finite
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import splat_floats
from flowabs_nodes.simd.memory import load, store_quads, store_triples
from flowabs_nodes.simd.pixelwise import any_nan, as_picture, as_run, empty_run, first_pixel, over_pixels, zero_or_nan
from flowabs_nodes.simd.premultiplied import load_rgba

InkColor = tuple[float, float, float, float]  # red, green, blue and opacity


def composite(
    rgb: npt.ArrayLike,
    lines: npt.ArrayLike,
    ink: Sequence[float] = (0.0, 0.0, 0.0),
    opacity: float = 1.0,
    alpha: npt.ArrayLike | None = None,
) -> Array:
    """Ink over a picture: rgb (1 - k) + ink A k with k = (1 - lines) opacity.

    Parameters
    ----------
    rgb
        (H, W, 3), premultiplied.
    lines
        (H, W), 1 paper and 0 ink.
    ink
        Three numbers, in the colours of ``rgb``.
    opacity
        0 to 1.
    alpha
        A, (H, W): there is ink only where there is a picture. None is 1 everywhere.

    Returns
    -------
    The picture with lines, (H, W, 3) float32, premultiplied by the same alpha.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    rgb = validate.planes("rgb", rgb, check_finite=False)
    lines = validate.plane("lines", lines, rgb.shape, check_finite=False)
    coverage = None if alpha is None else validate.plane("alpha", alpha, rgb.shape, check_finite=False)
    opacity = validate.number("opacity", opacity, min=0, max=1)
    color = tuple(validate.number("ink", value) for value in ink)
    if len(color) != 3:
        raise ArgumentError(f"ink: expected three numbers, found {len(color)}", parameter="ink")
    return inked(rgb, lines, (*color, opacity), coverage)


def inked(pixels: Array, lines: Array, ink: InkColor, alpha: Array | None = None) -> Array:
    """Ink over a picture of (H, W, 3), or one of (H, W, 4) with its own alpha, which stays."""
    channels = pixels.shape[2]
    drawing, there = as_run(lines), np.empty(0, np.float32) if alpha is None else as_run(alpha)
    result = empty_run(lines.size, channels)
    if any(over_pixels(_composite, drawing.size, as_run(pixels, channels), channels, drawing, ink, there, result)):
        for name, array in (("rgb", pixels), ("lines", lines), ("alpha", alpha)):
            if array is not None:
                refuse_non_finite(name, array)
    return as_picture(result, *pixels.shape)


@kernel
def _composite(
    first: int, last: int, pixels: Any, channels: int, lines: Any, ink: InkColor, alpha: Any, result: Any
) -> Any:
    total = splat_floats(0.0)
    for block in range(first, last):
        i = first_pixel(block, lines.size)
        r, g, b, a = load_rgba(pixels, channels, i)
        if alpha.size > 0:
            a = load(alpha, i)
        line = load(lines, i)
        total = total + (zero_or_nan(r) + zero_or_nan(g) + zero_or_nan(b)) + (zero_or_nan(a) + zero_or_nan(line))
        r, g, b = over(r, g, b, a, line, ink)
        if channels == 4:
            store_quads(result, 4 * i, (r, g, b, a))
        else:
            store_triples(result, 3 * i, (r, g, b))
    return any_nan(total)


@inlined
def over(r: Any, g: Any, b: Any, a: Any, line: Any, ink: InkColor) -> Any:
    """Ink on premultiplied pixels."""
    red, green, blue, opacity = ink
    k = (1.0 - line) * opacity
    paper, cover = 1.0 - k, a * k
    return r * paper + cover * red, g * paper + cover * green, b * paper + cover * blue
