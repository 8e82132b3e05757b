"""Region flattening (section 4.1): quantise lightness in bins of one size, with hard or soft steps."""

from __future__ import annotations

from typing import Any

import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters import validate
from flowabs_nodes.simd.finite import refuse_overflow
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import floor, from_doubles, maximum, minimum, rint, select, splat_floats, to_doubles
from flowabs_nodes.simd.memory import load, store
from flowabs_nodes.simd.pixelwise import any_nan, as_picture, as_run, empty_run, first_pixel, over_pixels, zero_or_nan

Steps = tuple[float, float]  # bins per unit of L*, and the softness of the step between bins


def quantize(lstar: npt.ArrayLike, levels: int = 8, softness: float = 0.0) -> Array:
    """Replace each lightness by the middle of its bin, of ``levels`` equal bins of 0..100.

    With D = 100 / levels and u = L* / D: Q = (max(1, ceil(u - 1e-3)) - 1/2) D. White is in bin ``levels``, zero and
    below in bin 1, and bins go on above white. With softness s, Q = (e - 1/2 + 3 t^2 - 2 t^3) D, at least 0, where
    e = round(u) and t = clamp((u - e) / s + 1/2, 0, 1).

    Parameters
    ----------
    lstar
        L* (H, W), white 100.
    levels
        Number of bins up to white, at least 1; typically 4 to 10.
    softness
        Width of the ramp from one bin to the next as a part of a bin, 0 (a hard step) to 1.

    Returns
    -------
    Q, (H, W) float32, in L*.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    lstar = validate.plane("lstar", lstar, check_finite=False)
    levels = validate.whole("levels", levels, min=1)
    softness = validate.number("softness", softness, min=0, max=1)
    run, flat = as_run(lstar), empty_run(lstar.size)
    picture = as_picture(flat, *lstar.shape)
    if any(over_pixels(_quantize, run.size, run, (levels / 100, softness), flat)):
        refuse_overflow("lstar", lstar, picture)
    return picture


@kernel
def _quantize(first: int, last: int, lstar: Array, steps: Steps, flat: Array) -> Any:
    """Quantise the blocks ``first`` .. ``last`` - 1 of sixteen pixels; return whether one is not finite, or Q."""
    total = splat_floats(0.0)
    for block in range(first, last):
        i = first_pixel(block, lstar.size)
        lightness = load(lstar, i)
        flattened = middle(lightness, steps)
        total = total + (zero_or_nan(lightness) + zero_or_nan(flattened))
        store(flat, i, flattened)
    return any_nan(total)


@inlined
def middle(lightness: Any, steps: Steps) -> Any:
    """Return Q of sixteen L*, in L*, as :func:`quantize` defines it."""
    per, softness = steps
    level = to_doubles(lightness) * per
    if softness == 0:
        return (maximum(_ceil(level - 1e-3), 1.0) - 0.5) * (1 / per)
    edge = rint(from_doubles(level))
    t = minimum(maximum(from_doubles(level - to_doubles(edge)) * (1 / softness) + 0.5, 0.0), 1.0)
    return maximum(edge - 0.5 + t * t * (3.0 - 2.0 * t), 0.0) * (1 / per)


@inlined
def _ceil(x: Any) -> Any:
    """Return sixteen float64, rounded up to whole numbers, as float32."""
    near = -floor(-from_doubles(x))
    return select(x > to_doubles(near), near + 1.0, near)  # if x was rounded down to a whole number, the next one
