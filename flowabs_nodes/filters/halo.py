"""How far each filter reads: its halo, in pixels to every side of the pixel that is computed.

A filter's result on a window of a picture has the same bits when the filter gets that window and its halo alone: every
sum runs over the same numbers in the same order, and streamlines are told apart by offsets from their pixel. Where the
halo would reach beyond the picture it ends at the picture's edge, so that the border is repeated there as in the whole
picture. Flows are taken to be unit tangents or shorter ones.

Filters with a number that comes of the whole picture have no halo here: ``lic`` (its noise fills the array), ``canny``,
``mean_shift``; and ``etf`` as soon as it fills tangents, chooses among kernels, or measures its gradient reference.

``factor`` is that by which a filter reduces the picture that it works on (``working_scale.py``), 1, 2 or 4.
"""

from __future__ import annotations

import math

from flowabs_nodes.filters.gaussian import LONGER, SURROUND, radius
from flowabs_nodes.filters.lines.soft_reach import lengths as soft_edge_lengths
from flowabs_nodes.filters.lines.soft_reach import steps_across
from flowabs_nodes.filters.lines.stroke_lengths import longest_walk, smoothing, widest

#: Sigma in pixels over which ``boil`` averages the flow, so that what meets at a corner moves together.
BOIL_EASE = 2.0

_SOBEL = 1  # pixels that a gradient reads to each side


def blur(sigma: float) -> int:
    """Return the halo of a Gaussian of ``sigma`` pixels, cut at ceil(3 sigma)."""
    return radius(sigma)


def dog(sigma_c: float) -> int:
    """Return the halo of a difference of Gaussians (eq. 8), that of the wider one."""
    return radius(SURROUND * sigma_c)


def along(steps: int) -> int:
    """Return the halo of so many steps of a pixel along a streamline or a line, with the pixel that samples reach."""
    return steps + 1 if steps > 0 else 0


def flow_blur(sigma: float) -> int:
    """Return the halo of a Gaussian of ``sigma`` pixels along the flow."""
    return along(radius(sigma))


def etf(radius: float, iterations: int, pre_blur: float, factor: int = 1) -> int:
    """Return the halo of ETF with a gradient reference that is a number, not adaptive, without fill."""
    footprint = max(math.ceil(radius / factor) - 1, 0)  # the open disc
    return _brought_up(blur(pre_blur / factor) + _SOBEL + iterations * footprint, factor)


def soft_edges(soft_reach: float) -> int:
    """Return the halo of what soft edges lack: gradients of a blurred picture, blurred along the flow."""
    t = soft_edge_lengths(soft_reach).t
    return blur(t) + along(steps_across(soft_reach)) + flow_blur(t)


def _across(sigma_c: float, pre_blur: float, factor: int) -> int:
    """Return the halo of the sums across the flow of a blurred picture, ``factor`` times smaller."""
    return blur(pre_blur / factor) + along(dog(sigma_c / factor))


def _thin_lines(width: float, sigma_c: float, pre_blur: float, factor: int, further: int) -> int:
    """Return the halo of bright lines of up to ``width`` pixels, in pixels of a picture ``factor`` times smaller.

    They are looked for in one that is ``further`` times smaller still, by a closing over twice the width and an
    opening, both across; the opening over twice the width reads no farther. What they find is blurred along the flow.
    """
    own = factor * further
    w = width / own
    found = 2 * along(math.ceil(w)) + 2 * along(math.ceil(w / 2)) + flow_blur(2 * w)
    return _brought_up(_across(sigma_c, pre_blur, own) + found, further)


def fdog(
    sigma_m: float,
    sigma_c: float,
    soft_reach: float | None = None,
    factor: int = 1,
    soft_factor: int = 1,
    thin_lines: float = 0.0,
    thin_factor: int = 1,
) -> int:
    """Return the halo of eq. 6, or of eqs. 10 and 11: across the flow at every point along it.

    ``soft_reach`` is None where soft edges are not looked for; ``soft_factor`` reduces the picture that they are
    measured in, if by more than ``factor``. ``thin_lines`` is 0 where thin lines are not looked for, ``thin_factor`` as
    ``soft_factor``.
    """
    return fdog_iterative(sigma_m, sigma_c, 1, 0, soft_reach, factor, soft_factor, thin_lines, thin_factor)


def fdog_iterative(
    sigma_m: float,
    sigma_c: float,
    iterations: int,
    pre_blur: float,
    soft_reach: float | None = None,
    factor: int = 1,
    soft_factor: int = 1,
    thin_lines: float = 0.0,
    thin_factor: int = 1,
) -> int:
    """Return the halo of ``iterations`` passes of FDoG, each of a picture that is blurred first.

    ``soft_reach``, ``thin_lines`` and their factors are as in :func:`fdog`. What soft edges lack, and what thin lines
    get, comes of the picture without ink.
    """
    across = _across(sigma_c, pre_blur, factor)
    further = max(soft_factor // factor, 1)
    soft = 0 if soft_reach is None else _brought_up(soft_edges(soft_reach / (factor * further)), further)
    thin = 0 if thin_lines == 0 else _thin_lines(thin_lines, sigma_c, pre_blur, factor, max(thin_factor // factor, 1))
    passes = iterations * flow_blur(sigma_m / factor) + (iterations - 1) * across + max(across, soft, thin)
    return _brought_up(passes, factor)


def evidence(sigma_m: float, evidence: float, factor: int = 1) -> int:
    """Return the halo of looking for evidence, on top of that of FDoG."""
    return 0 if evidence == 0 else _brought_up(flow_blur(LONGER * sigma_m / factor), factor)


def stroke(min_length: float, taper: float) -> int:
    """Return the halo of strokes: of walks along the flow, each step with half a pixel aside, and of their mean."""
    steps, across = longest_walk(min_length, taper), widest(min_length, taper)
    walk = along(math.ceil(math.hypot(1, 0.5) * steps)) + 1  # the ink on either side of a point
    return blur(smoothing(min_length, taper)) + max(walk, along(across))


def join_lines(gap: float) -> int:
    """Return the halo of joined lines: how many pixels away ink clears the paper, up to ``gap`` + 1/2 of them."""
    return math.ceil(gap + 0.5) - 1 if gap > 0 else 0


def ink_lines(widest: float, taper: float) -> int:
    """Return the halo of inked lines: of the foot of the farthest pixel with ink, and of what is told of its ends."""
    foot = math.ceil(widest + 0.5 + 1) + 1  # a crease is read a pixel beyond, between pixels
    return foot + (stroke(0, taper) if taper > 0 else 0)


def boil(amount: float) -> int:
    """Return the halo of displaced lines, and of the mean of the flow."""
    return max(boil_reach(amount), blur(BOIL_EASE)) if amount > 0 else 0


def boil_reach(amount: float) -> int:
    """Return how far away lines are read: the displacement, and the 4 x 4 pixels around a point."""
    return math.ceil(amount) + 2


def fbl(sigma_e: float, sigma_g: float, iterations: int, factor: int = 1) -> int:
    """Return the halo of FBL, or of a bilateral filter along straight lines."""
    passes = iterations * (flow_blur(sigma_e / factor) + flow_blur(sigma_g / factor))
    short_pass = flow_blur(min(sigma_e, factor)) if factor > 1 else 0
    return _brought_up(passes, factor) + short_pass


def _brought_up(pixels: int, factor: int) -> int:
    """Return the halo at full size of one of ``pixels`` on a picture reduced by ``factor``; without that the same.

    Bringing up reads two reduced pixels to each side, or one whose line is fitted to one more; and a window's edge may
    cut a block in two.
    """
    return pixels if factor == 1 else factor * (pixels + 3)


def bilateral_oriented(sigma_e: float, sigma_g: float, iterations: int, kernel: str) -> int:
    """Return the halo of the oriented bilateral filter. An "arc" bends away by kappa s^2 / 2, kappa at most sqrt 2."""
    if kernel == "line":
        return fbl(sigma_e, sigma_g, iterations)
    steps = radius(sigma_e)
    arc = along(math.ceil(math.hypot(steps, steps * steps / math.sqrt(2))))
    return iterations * (arc + flow_blur(sigma_g)) + 1  # the curvature reads the tangents beside the pixel


def quantize(by_gradient: float, gradient_length: float) -> int:
    """Return the halo of quantising, which reads other pixels only where steps go by the gradient."""
    return radius(gradient_length) + _SOBEL if by_gradient > 0 else 0


def bilateral(sigma_d: float, iterations: int) -> int:
    """Return the halo of ``iterations`` bilateral filters over +-ceil(3 sigma_d)."""
    return iterations * radius(sigma_d)


def rolling_guidance(sigma_s: float, iterations: int, factor: int = 1) -> int:
    """Return the halo of the Gaussian and ``iterations`` joint bilateral filters over +-ceil(3 sigma_s)."""
    return _brought_up((1 + iterations) * radius(sigma_s / factor), factor)
