"""Oriented bilateral filters: FBL with a straight line or an arc in place of its curve (Fig. 20 d and e)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array, Float64
from flowabs_nodes.choices import ORIENTED_KERNELS, SAMPLINGS
from flowabs_nodes.filters import validate
from flowabs_nodes.filters.regions.bilateral_line import line_pass
from flowabs_nodes.filters.regions.range_weights import partial_coverage, smooth_by_passes
from flowabs_nodes.sampling.coords import raster_of
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel


def bilateral_oriented(
    codes: npt.ArrayLike,
    flow: npt.ArrayLike,
    sigma_e: float = 2.0,
    r_e: float = 10.0,
    sigma_g: float = 0.5,
    r_g: float = 10.0,
    iterations: int = 5,
    kernel: str = "line",
    alpha: npt.ArrayLike | None = None,
    sampling: str = "nearest",
) -> Array:
    """Smooth along a line or arc that touches the flow, then across the flow, ``iterations`` times.

    In place of FBL's streamline c_x, eq. 12 samples the points x + s t + (kappa s^2 / 2) n, with t the pixel's tangent
    and n = (-t.y, t.x). "line": kappa = 0, the anisotropic bilateral filter. "arc": kappa is the curvature of the flow,
    kappa = n . (t . grad) t, and the points lie on the parabola of Pham's structure-adaptive bilateral filter [51].
    The pass across the flow is FBL's, eq. 14.

    Derivatives are central differences over two pixels, the border repeated, of tangents that are reversed where they
    disagree with the pixel's own tangent: a flow has no sign, and neither kappa n nor the filter depends on one.

    Parameters
    ----------
    codes
        Code values, (H, W, 3), not multiplied by alpha. Colours differ by their Euclidean distance.
    flow
        (H, W, 2), unit tangents, x right and y down. Where a tangent is zero, every sample is the pixel itself.
    sigma_e, sigma_g
        Sigma of the spatial kernel along and across the flow, in pixels, 0 to 10,000; 0 leaves that pass out.
    r_e, r_g
        Sigma of the range kernel along and across the flow (eq. 13), in code values, above 0.
    iterations
        At least 0; 0 gives a copy.
    kernel
        "line" or "arc". A parabola is an arc of the circle only near the pixel: where the flow turns by much within
        3 ``sigma_e``, it leaves the flow.
    alpha
        Coverage, (H, W). The weight of every sample is multiplied by its alpha. Pixels with alpha 0 or less keep their
        value. None is 1 everywhere.
    sampling
        How the picture is sampled, at the "nearest" pixel or "bilinear".

    Returns
    -------
    The smoothed code values, (H, W, 3) float32.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    codes = validate.planes("codes", codes, summed=True)
    flow = validate.flow_field(flow, codes.shape)
    sigma_e = validate.number("sigma_e", sigma_e, min=0, max=10_000)
    r_e = validate.number("r_e", r_e, above=0)
    sigma_g = validate.number("sigma_g", sigma_g, min=0, max=10_000)
    r_g = validate.number("r_g", r_g, above=0)
    iterations = validate.whole("iterations", iterations, min=0)
    arc = validate.choice("kernel", kernel, ORIENTED_KERNELS) == "arc"
    bilinear = validate.choice("sampling", sampling, SAMPLINGS) == "bilinear"
    covered, raster = partial_coverage(alpha, codes), raster_of(codes)
    passes = []
    if sigma_e > 0:
        kappa = curvature(flow) if arc else None
        passes.append(line_pass(flow, False, kappa, sigma_e, r_e, bilinear, covered, raster))
    if sigma_g > 0:
        passes.append(line_pass(flow, True, None, sigma_g, r_g, bilinear, covered, raster))
    return smooth_by_passes(codes, covered, raster, passes, iterations)


def curvature(flow: Array) -> npt.NDArray[np.float64]:
    """Return the curvature kappa of a flow (H, W, 2) at each pixel, (H, W) float64, in 1 / pixel."""
    kappa = np.empty(flow.shape[:2])
    over_rows(_curvature, flow.shape[0], flow, kappa)
    return kappa


@kernel
def _curvature(first: int, last: int, flow: Array, kappa: Float64) -> None:
    """Write rows ``first`` .. ``last`` - 1 of kappa = n . (t . grad) t, n = (-t.y, t.x)."""
    height, width, _ = flow.shape
    for y in range(first, last):
        above, below = max(y - 1, 0), min(y + 1, height - 1)
        for x in range(width):
            left, right = max(x - 1, 0), min(x + 1, width - 1)
            tx, ty = np.float64(flow[y, x, 0]), np.float64(flow[y, x, 1])
            x2, y2 = _agreeing(flow[y, right], tx, ty)
            x1, y1 = _agreeing(flow[y, left], tx, ty)
            x4, y4 = _agreeing(flow[below, x], tx, ty)
            x3, y3 = _agreeing(flow[above, x], tx, ty)
            change_x = tx * ((x2 - x1) / 2) + ty * ((x4 - x3) / 2)  # (t . grad) t
            change_y = tx * ((y2 - y1) / 2) + ty * ((y4 - y3) / 2)
            kappa[y, x] = tx * change_y - ty * change_x


@inlined
def _agreeing(tangent: Array, tx: float, ty: float) -> tuple[float, float]:
    """Return a tangent (2,), reversed where it disagrees with (tx, ty)."""
    x, y = np.float64(tangent[0]), np.float64(tangent[1])
    return (-x, -y) if x * tx + y * ty < 0 else (x, y)
