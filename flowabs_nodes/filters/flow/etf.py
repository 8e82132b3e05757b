"""The edge tangent flow (ETF, section 2 of the paper), exact, at a cost that grows with the radius and not its square.

Eq. 1 sums phi w_d t(y) = (t(x).t(y)) t(y) = N(y) t(x) with N = t t^T: eqs. 4 and 5 are the product with a tensor that
does not depend on x. w_m (eq. 3) is linear in ĝ(y). So, k normalising,

    t'(x) = 1/k [(1 - ĝ(x)) sum N + sum ĝN] t(x),

and only N and ĝN have to be summed over the footprint, the open disc of w_s (``footprint_sums.py``). The trace |t|^2 of
N is the same in every iteration; the rest of N is c = t.x^2 - t.y^2 and s = 2 t.x t.y (``etf_update.py``). Sums are
integers in fixed point, so they are exact however the picture is divided among threads (``etf_passes.py``).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.choices import ETF_KERNELS
from flowabs_nodes.filters import validate
from flowabs_nodes.filters.flow import gradient
from flowabs_nodes.filters.flow.adaptive import kernel_choice, radii
from flowabs_nodes.filters.flow.etf_passes import smooth
from flowabs_nodes.filters.flow.fill import flow_fill
from flowabs_nodes.filters.flow.flow_resolution import enlarged_flow
from flowabs_nodes.filters.flow.footprint_sums import footprint_passes
from flowabs_nodes.filters.flow.known_edges import edges_of, with_edges
from flowabs_nodes.filters.working_scale import SOBEL, flow_factor, shortened_blur
from flowabs_nodes.sampling.resolution import reduced


def etf(
    code: npt.ArrayLike,
    radius: float = 5.0,
    iterations: int = 3,
    kernel: str = "full",
    pre_blur: float = 0.0,
    gradient_reference: str | float = "max",
    fill: float | None = 0.0,
    adaptive: bool = False,
    mask: npt.ArrayLike | None = None,
    working_scale: str = "full",
    edge_strength: npt.ArrayLike | None = None,
    edge_flow: npt.ArrayLike | None = None,
    edge_weight: float = 60.0,
) -> Array:
    """Return the edge tangent flow, eqs. 1-5: a smooth field of tangents that keeps the directions of strong edges.

    The sum of eq. 1 is over the image: pixels of the kernel that lie outside the picture take no part.

    Parameters
    ----------
    code
        Code values, (H, W), or (H, W, 3) for the flow of all channels together (g along the major eigenvector of
        sum_k g_k g_k^T, |g| = sqrt(lambda_1)).
    radius
        Radius mu of the kernel in pixels, at least 0: the open disc dx^2 + dy^2 < radius^2 (eq. 2). Up to 1 it holds
        the centre alone and changes nothing.
    iterations
        How often the field is smoothed (section 2.3); 0 gives the tangents of the gradient.
    kernel
        "full", the disc, or "separable": in each iteration a pass along x and one along y over |d| < radius (2.4).
    pre_blur
        Sigma in pixels of a Gaussian blur of ``code`` before its gradient.
    gradient_reference
        Gradient in code values per pixel that counts as full strength, ĝ = min(|g| / reference, 1): "max" of the
        picture (the paper), a percentile such as "p99.5", or a number of at least 0; a reference of 0 gives ĝ = 0.
    fill
        Gradient in code values per pixel below which a tangent first leans on the average around it, the more the
        weaker it is; 0 fills only where there is no gradient, None leaves zero tangents there (the paper).
    adaptive
        Whether pixels in texture smaller than the kernel take a kernel of half the radius, a quarter and so on, down to
        2.5 pixels (see :mod:`~flowabs_nodes.filters.flow.adaptive`).
    mask
        How much each pixel counts, (H, W), 0 to 1; None is 1 everywhere. Its gradient, and its weight in eq. 1 and in
        the fill, are multiplied by the mask. So a pixel at 0 has no gradient of its own and turns no tangent around it;
        like other holes it is filled from its surroundings. Percentiles of ``gradient_reference`` leave it out. The
        gradient of a pixel beside the mask's edge still sees what lies beyond it.
    working_scale
        The size of the picture that is worked on: "full"; "1/2" or "1/4" of its width and height, lengths and
        quantities per pixel to match, the flow brought back up; or "auto": 1/2 where it leaves the radius at least 10
        pixels, with ``adaptive`` the least radius, and ``pre_blur`` at least 1; 1/4 where it leaves twice as much.
    edge_strength
        Edges that are known from elsewhere: how sure one is at each pixel, (H, W), 0 to 1. Needs ``edge_flow``.
    edge_flow
        Their tangents, (H, W, 2); the sign has no meaning.
    edge_weight
        The gradient that an edge of full strength counts as, beside the picture's own
        (:mod:`~flowabs_nodes.filters.flow.known_edges`), in code values per pixel, at least 0.

    Returns
    -------
    (H, W, 2) float32, unit tangents, x right and y down; the sign has no meaning. An image without any gradient has
    (1, 0) everywhere, zeros with ``fill=None``.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    return etf_and_reference(
        code,
        radius,
        iterations,
        kernel,
        pre_blur,
        gradient_reference,
        fill=fill,
        adaptive=adaptive,
        mask=mask,
        working_scale=working_scale,
        edge_strength=edge_strength,
        edge_flow=edge_flow,
        edge_weight=edge_weight,
    )[0]


def etf_and_reference(
    code: npt.ArrayLike,
    radius: float,
    iterations: int,
    kernel: str,
    pre_blur: float,
    gradient_reference: str | float,
    *,
    fill: float | None,
    adaptive: bool,
    mask: npt.ArrayLike | None = None,
    working_scale: str = "full",
    edge_strength: npt.ArrayLike | None = None,
    edge_flow: npt.ArrayLike | None = None,
    edge_weight: float = 60.0,
) -> tuple[Array, float]:
    """Return :func:`etf`, and the reference it used: the gradient of full strength, in code values per pixel."""
    code = validate.plane_or_planes("code", code)
    radius = validate.number("radius", radius, min=0)
    iterations = validate.whole("iterations", iterations, min=0)
    kernel = validate.choice("kernel", kernel, ETF_KERNELS)
    pre_blur = validate.number("pre_blur", pre_blur, min=0, max=10_000)
    gradient.check_reference(gradient_reference)
    fill = None if fill is None else validate.number("fill", fill, min=0)
    adaptive = validate.flag("adaptive", adaptive)
    counts = None if mask is None else validate.matte("mask", mask, code.shape)
    edges = edges_of(edge_strength, edge_flow, edge_weight, code.shape)
    factor = flow_factor(working_scale, radii(radius)[-1] if adaptive else radius, pre_blur)
    if factor > 1:
        known = None if edges is None else edges.reduced(factor)
        small, reference = etf_and_reference(
            reduced(code, factor),
            radius / factor,
            iterations,
            kernel,
            shortened_blur(pre_blur, factor, SOBEL),
            gradient_reference if isinstance(gradient_reference, str) else gradient_reference * factor,
            fill=None if fill is None else fill * factor,
            adaptive=adaptive,
            mask=None if counts is None else reduced(counts, factor),
            edge_strength=None if known is None else known.strength,
            edge_flow=None if known is None else known.flow,
            edge_weight=edge_weight if known is None else known.weight,
        )
        return enlarged_flow(small, factor, *code.shape[:2]), reference / factor

    measured = gradient.measured(code, pre_blur)
    if edges is not None:
        measured = with_edges(measured, edges)
    if counts is not None:
        measured = gradient.masked(measured, counts)
    tangent, magnitude = measured.gradient
    if fill is not None and not (fill == 0 and measured.everywhere and counts is None):
        tangent = flow_fill(tangent, magnitude, fill, measured.largest, counts)
    reference = gradient.reference(measured, gradient_reference, counts)
    if iterations == 0 or radius <= 1:
        return tangent, reference
    sizes = radii(radius) if adaptive else [radius]
    choice = kernel_choice(code, radius, counts).astype(np.int32) if len(sizes) > 1 else None
    passes = footprint_passes(kernel, sizes, *magnitude.shape)
    return smooth(tangent, magnitude, reference, iterations, passes, choice, counts), reference
