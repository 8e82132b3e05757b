"""The size that a filter works at: a picture reduced by a factor of 1, 2 or 4, its lengths shortened alike.

Lengths of many pixels leave nothing in a filter's result that is as fine as a pixel. Such a filter does the same on a
reduced picture, in a fraction of the time, and what it makes is brought back up to the full size. The factor follows
from the parameters alone, so that it is the same on every machine, for the whole picture and for each part of it.

A length that must not become shorter than so many pixels of the reduced picture is given beside that limit in the
functions here, which are the whole rule of "auto". The other lengths of a filter are shortened with it.
"""

from __future__ import annotations

import math

from flowabs_nodes.choices import WORKING_SCALES

_FACTORS = {"full": 1, "1/2": 2, "1/4": 4}

#: What sampling blurs, as a variance in px^2 along each axis: a pixel is a mean over its square, which has 1/12.
PIXEL = 1 / 12
#: The same for a 3x3 Sobel filter, whose weights 1/4, 1/2, 1/4 across the difference have a variance of 1/2,
SOBEL = PIXEL + 1 / 2
#: and for a picture that is read bilinearly twice: between pixels by a fraction u it is u (1 - u), 1/6 in the mean, and
#: less where the flow lies along the pixels.
READ_TWICE = PIXEL + 1 / 4


def flow_factor(working_scale: str, radius: float, pre_blur: float) -> int:
    """Return the factor of the edge tangent flow; ``radius`` is that of its smallest kernel.

    Unless the picture is blurred first an edge is as sharp as a pixel, and a reduced picture's gradients are others.
    """
    return _factor(working_scale, (radius, 10.0), (pre_blur, 1.0))


def lines_factor(working_scale: str, sigma_c: float, passes: int = 1, pre_blur: float = 0.0) -> int:
    """Return the factor of lines. The threshold draws them at full size, so that ink stays crisp.

    The ink of a pass is what the next one looks at: with several, the Gaussians before the response must be longer in
    all, or lines fork where they do not at full size.
    """
    together = math.hypot(sigma_c, pre_blur) if passes > 1 else math.inf
    return _factor(working_scale, (sigma_c, 2.0), (together, 2.8))


def step_along(working_scale: str, sigma_m: float, pre_blur: float) -> int:
    """Return how many steps along the flow lie between the samples that responses are summed of: 1, 2 or 3.

    ``pre_blur`` is the blur of the picture and ``sigma_m`` the one along the flow, in pixels of the size that is worked
    on. A Gaussian of 1.1 steps leaves less than three thousandths of what is as fine as two of them: samples that far
    apart have the same sum, as long as their weights change little from one to the next.
    """
    return 1 if working_scale == "full" else int(max(1, min(pre_blur / 1.1, sigma_m / 1.5, 3)))


def step_across(working_scale: str, sigma_c: float, pre_blur: float) -> int:
    """Return the same for the sum across the flow, whose narrower Gaussian is ``sigma_c``: 1 or 2."""
    return 1 if working_scale == "full" else int(max(1, min(pre_blur / 1.1, sigma_c / 0.9, 2)))


def step_of_smoothing(working_scale: str, smooth: float) -> int:
    """Return the same for lines that are blurred along the flow in the end by ``smooth`` pixels of the full size."""
    return 2 if working_scale != "full" and smooth >= 3.0 else 1


def soft_edges_factor(working_scale: str, t: float) -> int:
    """Return the factor of what soft edges lack; ``t`` is the blur of the picture in which they are measured."""
    return _factor(working_scale, (t, 3.0))


def thin_lines_factor(working_scale: str, thin_lines: float, sigma_c: float, pre_blur: float) -> int:
    """Return the factor of looking for bright lines of up to ``thin_lines`` pixels; 0 looks for none.

    What becomes of them is as smooth as the Gaussians before the response together.
    """
    return _factor(working_scale, (thin_lines, 3.5), (math.hypot(sigma_c, pre_blur), 1.4))


def evidence_factor(working_scale: str, sigma_c: float, pre_blur: float) -> int:
    """Return the factor of looking for evidence, which blurs ink along the flow alone.

    Across it ink is as wide as the Gaussians before the response, and must stay wider than a pixel.
    """
    return _factor(working_scale, (math.hypot(sigma_c, pre_blur), 1.4))


def regions_factor(working_scale: str, sigma_e: float, sigma_g: float) -> int:
    """Return the factor of the flow-based bilateral filter; a pass of sigma 0 is left out, and asks for nothing."""
    return _factor(working_scale, (sigma_e or math.inf, 4.0), (sigma_g or math.inf, 2.0))


def guidance_factor(working_scale: str, sigma_s: float) -> int:
    """Return the factor of rolling guidance."""
    return _factor(working_scale, (sigma_s, 4.0))


def _factor(working_scale: str, *lengths: tuple[float, float]) -> int:
    """Return the factor that ``working_scale`` says; of "auto" the largest at which no length is below its limit.

    Limits are in pixels of a picture reduced by 2. By 4 what is fine at full size gets lost as well, unless lengths are
    twice as long there too.
    """
    from flowabs_nodes.filters import validate  # what numba compiles is not imported for a declaration

    if validate.choice("working_scale", working_scale, WORKING_SCALES) != "auto":
        return _FACTORS[working_scale]
    fitting = (each for each in (4, 2) if all(length >= limit * each**2 / 2 for length, limit in lengths))
    return next(fitting, 1)


def shortened_blur(sigma: float, factor: int, own: float) -> float:
    """Return the sigma on a reduced picture that blurs as much as ``sigma`` pixels do at full size.

    ``own`` is the variance in px^2 by which sampling blurs at either size: sigma^2 + own is what is shortened. The
    result is at least half of ``sigma`` / ``factor``.
    """
    if factor == 1:
        return sigma
    return math.sqrt(max((sigma**2 + own) / factor**2 - own, (sigma / factor / 2) ** 2))


def shortened_range(r: float, factor: int) -> float:
    """Return the range kernel's sigma on a reduced picture: a tenth less each time it is halved.

    A reduced pixel is a mean and differs less from its neighbours than pixels do. A tenth brought the flats of three
    photographs, each at half its size, nearest to those of the full size.
    """
    return r / math.pow(factor, 0.15)
