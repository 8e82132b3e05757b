"""Region flattening (section 4.1): quantise lightness in bins of one size, with hard or soft steps.

Steps may be hard only where lightness rises steeply, after Winnemöller, Olsen and Gooch, "Real-time video abstraction"
(SIGGRAPH 2006), section 3.3: a clear sky then keeps its ramp, and steps stay steady in motion.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters import validate
from flowabs_nodes.filters.regions.rise import rise
from flowabs_nodes.simd.finite import refuse_overflow
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import floor, from_doubles, maximum, minimum, rint, select, splat_floats, to_doubles
from flowabs_nodes.simd.memory import load, store
from flowabs_nodes.simd.pixelwise import any_nan, as_picture, as_run, empty_run, first_pixel, over_pixels, zero_or_nan

_LEVEL = 0.45  # how much of a step is left where lightness is level: the output's slope is .55 to 1.23 of the input's
_NARROWEST = 1e-6  # of a bin: a step that is narrower is hard


class Steps(NamedTuple):
    """What the steps are like, as one argument of a kernel."""

    per: float  # bins per unit of L*
    softness: float  # width of the step between bins, as a part of a bin
    phase: float = 0.0  # how far the bins lie above those of 0, in bins
    by_gradient: float = 0.0  # how far the rise of lightness decides on the step, 0 to 1
    hard: float = 1.0  # 1 / the rise from which steps are hard


def quantize(
    lstar: npt.ArrayLike,
    levels: int = 8,
    softness: float = 0.0,
    phase: float = 0.0,
    by_gradient: float = 0.0,
    gradient_length: float = 1.0,
    hard_gradient: float = 5.0,
) -> Array:
    """Replace each lightness by the middle of its bin, of ``levels`` equal bins of 0..100.

    With D = 100 / levels, u = L* / D and the phase f: Q = max(ceil(u - f - 1e-3) - 1/2 + f, f / 2) D, of f = 0
    max(.., 1/2) D. White is in bin ``levels``, zero and below in bin 1, and bins go on above white; of the bin that a
    phase cuts off at black, Q is the middle of what is left. With softness s, Q = max(e - 1/2 + f + 3 t^2 - 2 t^3,
    f / 2) D, where e = round(u - f) and t = clamp((u - f - e) / s + 1/2, 0, 1).

    By the gradient, with g the rise of L* (:mod:`~flowabs_nodes.filters.regions.rise`), h = smoothstep(0,
    ``hard_gradient``, g) and a = ``by_gradient``: s becomes s + a (w - s) with w = clamp(g / D, 1 - h, 1), the whole
    bin where lightness is level, and never so narrow that a step takes less than the gradient's length, which would
    be jagged; and the result is L* + (Q - L*) (1 - .55 a (1 - h)).

    Parameters
    ----------
    lstar
        L* (H, W), white 100.
    levels
        Number of bins up to white, at least 1; typically 4 to 10.
    softness
        Width of the ramp from one bin to the next as a part of a bin, 0 (a hard step) to 1.
    phase
        How far all steps move up, as a part of a bin, 0 to 1.
    by_gradient
        How far the steepness of lightness decides how hard a step is, 0 (not at all) to 1.
    gradient_length
        Sigma in pixels of the Gaussian before the gradient, and the length that its rise is of; above 0 to 200.
    hard_gradient
        Rise of L* over that length from which a step is hard, above 0.

    Returns
    -------
    Q, (H, W) float32, in L*.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    lstar = validate.plane("lstar", lstar, check_finite=False)
    steps = Steps(
        validate.whole("levels", levels, min=1) / 100,
        validate.number("softness", softness, min=0, max=1),
        validate.number("phase", phase, min=0, max=1),
        validate.number("by_gradient", by_gradient, min=0, max=1),
        1 / validate.number("hard_gradient", hard_gradient, min=1e-6, max=1e6),
    )
    gradient_length = validate.number("gradient_length", gradient_length, above=0, max=200)
    rises = as_run(rise(lstar, gradient_length)) if steps.by_gradient > 0 else np.empty(0, np.float32)
    run, flat = as_run(lstar), empty_run(lstar.size)
    picture = as_picture(flat, *lstar.shape)
    if any(over_pixels(_quantize, run.size, run, steps, rises, flat)):
        refuse_overflow("lstar", lstar, picture)
    return picture


@kernel
def _quantize(first: int, last: int, lstar: Array, steps: Steps, rises: Array, flat: Array) -> Any:
    """Quantise the blocks ``first`` .. ``last`` - 1 of sixteen pixels; return whether one is not finite, or Q."""
    total = splat_floats(0.0)
    for block in range(first, last):
        i = first_pixel(block, lstar.size)
        lightness, steep = load(lstar, i), splat_floats(0.0)
        if rises.size > 0:
            steep = load(rises, i)
        flattened = flatten(lightness, steep, steps)
        total = total + (zero_or_nan(lightness) + zero_or_nan(flattened))
        store(flat, i, flattened)
    return any_nan(total)


@inlined
def flatten(lightness: Any, steep: Any, steps: Steps) -> Any:
    """Return what :func:`quantize` makes of sixteen L* whose rises are ``steep``, in L*."""
    per, softness, phase, by_gradient, hard = steps
    if by_gradient > 0:
        x = minimum(maximum(steep * hard, 0.0), 1.0)
        soft = 1.0 - x * x * (3.0 - 2.0 * x)  # 1 - h
        width = softness + (minimum(maximum(soft, steep * per), 1.0) - softness) * by_gradient
        stepped = _soft_step(lightness, 1.0 / maximum(width, _NARROWEST), steps)
        return lightness + (stepped - lightness) * (1.0 - soft * (by_gradient * (1 - _LEVEL)))
    if softness > 0:
        return _soft_step(lightness, splat_floats(1 / softness), steps)
    level = to_doubles(lightness) * per
    lowest = 0.5 * phase if phase > 0 else 0.5
    return maximum(_ceil(level - (phase + 1e-3)) + (phase - 0.5), lowest) * (1 / per)


@inlined
def _soft_step(lightness: Any, steepness: Any, steps: Steps) -> Any:
    """Return Q of sixteen L* in L*, with steps of a width of 1 / ``steepness`` bins."""
    per, _, phase, _, _ = steps
    level = to_doubles(lightness) * per
    edge = rint(from_doubles(level - phase))
    t = minimum(maximum(from_doubles(level - (to_doubles(edge) + phase)) * steepness + 0.5, 0.0), 1.0)
    return maximum(edge + (phase - 0.5) + t * t * (3.0 - 2.0 * t), 0.5 * phase) * (1 / per)


@inlined
def _ceil(x: Any) -> Any:
    """Return sixteen float64, rounded up to whole numbers, as float32."""
    near = -floor(-from_doubles(x))
    return select(x > to_doubles(near), near + 1.0, near)  # if x was rounded down to a whole number, the next one
