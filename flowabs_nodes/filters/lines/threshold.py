"""Turn a response into lines by eq. 9, hard or soft."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters import validate
from flowabs_nodes.simd.finite import refuse_non_finite
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.known_finite import mark_finite
from flowabs_nodes.simd.lanes import maximum, minimum, select, splat_floats
from flowabs_nodes.simd.memory import load, store
from flowabs_nodes.simd.pixelwise import any_nan, as_picture, as_run, empty_run, first_pixel, over_pixels, zero_or_nan


def threshold(response: npt.ArrayLike, tau: float = 0.5, contrast: float | None = None, softness: float = 0.0) -> Array:
    """Draw ink where H < -c, which is eq. 9 (H < 0 and 1 + tanh H < tau) for c = -atanh(tau - 1).

    Parameters
    ----------
    response
        H in code values, (H, W).
    tau
        Threshold of eq. 9, 0 to 1: 0 draws no ink, 1 draws ink wherever H < 0. Not used when ``contrast`` is given.
    contrast
        c in code values, at least 0; None is -atanh(tau - 1).
    softness
        s in code values, at least 0: 0 is binary, else lines = smoothstep(-c - s, -c, H).

    Returns
    -------
    Lines, (H, W) float32, 1 paper and 0 ink.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    response = validate.plane("response", response, check_finite=False)
    tau = validate.number("tau", tau, min=0, max=1)
    softness = validate.number("softness", softness, min=0)
    if contrast is not None:
        contrast = validate.number("contrast", contrast, min=0)
    elif tau == 0:
        contrast = math.inf
    else:
        contrast = (math.log(2 - tau) - math.log(tau)) / 2  # -atanh(tau - 1), also where tau - 1 rounds to -1
    run, lines = as_run(response), empty_run(response.size)
    if any(over_pixels(_threshold, run.size, run, *_ramp(-contrast, softness), lines)):
        refuse_non_finite("response", response)
    return mark_finite(as_picture(lines, *response.shape))


def _ramp(paper: float, softness: float) -> tuple[np.float32, np.float32, np.float32]:
    """Return the H where paper begins, in float32; what float32 left out of it; the slope of the ramp below it.

    Slope 0 stands for a step, which is as exact as in float64: the H returned is then the least float32 that is not
    below ``paper``.
    """
    with np.errstate(over="ignore"):
        edge = np.float32(paper)
        above = edge if edge >= paper else np.nextafter(edge, np.float32(np.inf))
    if softness == 0 or np.isinf(edge):
        return above, np.float32(0), np.float32(0)
    slope = min(max(1 / softness, 1e-37), 1e37)  # no subnormal number, no Inf
    return edge, np.float32(paper - float(edge)), np.float32(slope)


@kernel
def _threshold(first: int, last: int, response: Array, paper: float, rest: float, slope: float, lines: Array) -> Any:
    """Draw the blocks ``first`` .. ``last`` - 1 of sixteen pixels; return whether a number is not finite.

    ``paper``, ``rest`` and ``slope`` come from :func:`_ramp`.
    """
    total = splat_floats(0.0)
    for block in range(first, last):
        i = first_pixel(block, response.size)
        h = load(response, i)
        total = total + zero_or_nan(h)
        if slope == 0:
            line = select(h < paper, splat_floats(0.0), splat_floats(1.0))  # eq. 9
        else:
            t = minimum(maximum(((h - paper) - rest) * slope + 1.0, 0.0), 1.0)
            line = t * t * (3.0 - 2.0 * t)
        store(lines, i, line)
    return any_nan(total)
