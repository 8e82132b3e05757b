"""Composite lines over a picture, in ink of any colour."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import validate
from flowabs_nodes.simd.finite import refuse_non_finite, refuse_overflow
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import splat_floats
from flowabs_nodes.simd.memory import load, load_triples, store_quads, store_triples
from flowabs_nodes.simd.pixelwise import any_nan, as_picture, as_run, empty_run, first_pixel, over_pixels, zero_or_nan
from flowabs_nodes.simd.premultiplied import load_rgba

InkColor = tuple[float, float, float, float]  # red, green, blue, in the colours of the picture, and opacity


def composite(
    rgb: npt.ArrayLike,
    lines: npt.ArrayLike,
    ink: Sequence[float] | Array = (0.0, 0.0, 0.0),
    opacity: float = 1.0,
    alpha: npt.ArrayLike | None = None,
) -> Array:
    """Lay ink over a picture: rgb (1 - k) + ink A k with k = (1 - lines) opacity.

    Parameters
    ----------
    rgb
        (H, W, 3), premultiplied.
    lines
        (H, W), 1 paper and 0 ink.
    ink
        Three numbers, in the colours of ``rgb``; or (H, W, 3), those of each pixel, as of
        :func:`~flowabs_nodes.filters.ink_color`.
    opacity
        0 to 1.
    alpha
        A, (H, W): ink covers a pixel as far as the picture does. None is 1 everywhere.

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
    if isinstance(ink, np.ndarray) and ink.ndim == 3:
        colors = validate.planes("ink", ink, check_finite=False)
        validate.plane("ink", colors[..., 0], rgb.shape, check_finite=False)  # the size of the picture
        return inked(rgb, lines, (0.0, 0.0, 0.0, opacity), coverage, colors)
    color = tuple(validate.number("ink", value) for value in ink)
    if len(color) != 3:
        raise ArgumentError(f"ink: expected three numbers, found {len(color)}", parameter="ink")
    return inked(rgb, lines, (*color, opacity), coverage)


def inked(pixels: Array, lines: Array, ink: InkColor, alpha: Array | None = None, colors: Array | None = None) -> Array:
    """Return a picture with ink over it: (H, W, 3), or (H, W, 4) with an alpha of its own, which stays as it was.

    ``colors``, (H, W, 3), is an ink of each pixel's own, of which ``ink`` has the opacity. Parameters are else those of
    :func:`composite`, checked but for finiteness: ArgumentError if a pixel is not finite.
    """
    channels = pixels.shape[2]
    absent = np.empty(0, np.float32)
    coverage = absent if alpha is None else as_run(alpha)
    inks = absent if colors is None else as_run(colors, 3)
    drawing, result = as_run(lines), empty_run(lines.size, channels)
    picture = as_picture(result, *pixels.shape)
    run = as_run(pixels, channels)
    if any(over_pixels(_composite, drawing.size, run, channels, drawing, ink, inks, coverage, result)):
        for name, array in (("rgb", pixels), ("lines", lines), ("ink", colors), ("alpha", alpha)):
            if array is not None:
                refuse_non_finite(name, array)
        refuse_overflow("rgb" if alpha is None else "alpha", pixels if alpha is None else alpha, picture)
    return picture


@kernel
def _composite(
    first: int,
    last: int,
    pixels: Array,
    channels: int,
    lines: Array,
    ink: InkColor,
    colors: Array,
    alpha: Array,
    result: Array,
) -> bool:
    """Write the blocks of sixteen pixels ``first`` .. ``last`` - 1, and return whether one is not finite.

    ``pixels`` and ``result`` are (H, W, channels) flattened, ``lines`` and ``alpha`` (H, W), ``colors`` (H, W, 3). An
    empty ``alpha`` stands for the picture's own, or 1, and empty ``colors`` for ``ink`` everywhere.
    """
    total = splat_floats(0.0)
    for block in range(first, last):
        i = first_pixel(block, lines.size)
        r, g, b, a = load_rgba(pixels, channels, i)
        if alpha.size > 0:
            a = load(alpha, i)
        red, green, blue = splat_floats(ink[0]), splat_floats(ink[1]), splat_floats(ink[2])
        if colors.size > 0:
            red, green, blue = load_triples(colors, 3 * i)
        r, g, b = over(r, g, b, a, load(lines, i), (red, green, blue, ink[3]))  # not finite if one of these is not
        total = total + (zero_or_nan(r) + zero_or_nan(g) + zero_or_nan(b))
        if channels == 4:
            store_quads(result, 4 * i, (r, g, b, a))
        else:
            store_triples(result, 3 * i, (r, g, b))
    found: bool = any_nan(total)
    return found


@inlined
def over(r: Any, g: Any, b: Any, a: Any, line: Any, ink: Any) -> Any:
    """Return r, g and b of sixteen premultiplied pixels of coverage a, with ink over them where ``line`` is below 1."""
    red, green, blue, opacity = ink
    k = (1.0 - line) * opacity
    paper, cover = 1.0 - k, a * k
    return r * paper + cover * red, g * paper + cover * green, b * paper + cover * blue
