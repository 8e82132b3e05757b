"""The rolling guidance filter (Zhang et al., ECCV 2014): structure smaller than a scale goes, edges around it stay."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters import gaussian, validate
from flowabs_nodes.filters.regions.affine_upsampling import upsampled
from flowabs_nodes.filters.regions.plane_rows import (
    Planes,
    as_codes,
    as_plane_rows,
    load_color,
    repeat_borders,
    row_of,
    store_mean,
)
from flowabs_nodes.filters.regions.range_weights import (
    Sums,
    WeightExponents,
    partial_coverage,
    start_sums,
    weight_exponents,
)
from flowabs_nodes.filters.working_scale import guidance_factor, shortened_range
from flowabs_nodes.sampling.resolution import reduced
from flowabs_nodes.sampling.samples import Color
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.elementary import exp2_weight
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, Floats, splat_floats

# Columns are summed for blocks of so many rows, so many columns at a time: what they read then stays in the cache.
_ROWS, _COLUMNS = 8, 512


def rolling_guidance(
    codes: npt.ArrayLike,
    sigma_s: float = 2.0,
    sigma_r: float = 15.0,
    iterations: int = 3,
    alpha: npt.ArrayLike | None = None,
    working_scale: str = "full",
) -> Array:
    """Remove structure smaller than a scale and keep the edges of what is larger.

    J_0 = G(sigma_s) * I: what is small is gone, and so are all edges. Then, ``iterations`` times, the mean of the
    picture I itself among pixels that are alike in J_k: J_{k+1}(p) = sum_q w I_q / sum_q w with w =
    exp(-|p - q|^2 / 2 sigma_s^2) exp(-|J_k(p) - J_k(q)|^2 / 2 sigma_r^2). Edges that J_0 still shows come back sharp,
    and what it does not show never comes back. Both sums run over columns, then rows, guided by the same J_k.

    Parameters
    ----------
    codes
        Code values I, (H, W, 3), not multiplied by alpha. Colours differ by their Euclidean distance.
    sigma_s
        The scale in pixels, 0 to 1,000: the sigma of both Gaussians, cut at ceil(3 sigma_s). 0 gives a copy. The border
        is repeated.
    sigma_r
        Sigma of the range kernel in code values, above 0.
    iterations
        At least 0; 0 gives J_0. Three are enough for most edges to settle.
    alpha
        Coverage, (H, W). The weight of every pixel is multiplied by its alpha, so that the colour of an uncovered pixel
        never shows. Pixels with alpha 0 or less keep their value. None is 1 everywhere.
    working_scale
        The size of the picture that is worked on: "full"; "1/2" or "1/4" of its width and height, ``sigma_s`` to match,
        the result brought back up along the edges of ``codes``
        (:mod:`~flowabs_nodes.filters.regions.affine_upsampling`); or "auto": 1/2 where it leaves ``sigma_s`` at
        least 4 pixels, 1/4 where it leaves 8.

    Returns
    -------
    J, (H, W, 3) float32, in code values.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    codes = validate.planes("codes", codes, summed=True)
    sigma_s = validate.number("sigma_s", sigma_s, min=0, max=1000)
    sigma_r = validate.number("sigma_r", sigma_r, above=0)
    iterations = validate.whole("iterations", iterations, min=0)
    covered = partial_coverage(alpha, codes)
    factor = guidance_factor(working_scale, sigma_s)
    if sigma_s == 0:
        return codes.copy()
    if factor > 1:
        share, small = None if covered is None else reduced(covered, factor), reduced(codes, factor, covered)
        range_sigma = shortened_range(sigma_r, factor)
        smoothed = rolling_guidance(small, sigma_s / factor, range_sigma, iterations, share)
        return upsampled(codes, small, smoothed, factor, covered, share)

    picture, planes = as_plane_rows(codes, covered, gaussian.radius(sigma_s))
    weights, by_alpha = weight_exponents(sigma_s, sigma_r), None if covered is None else True
    guide, smoothed = np.empty_like(picture), np.empty_like(picture)
    over_rows(_smooth, planes.height, picture, None, weights, planes, by_alpha, guide)
    for _ in range(iterations):
        over_rows(_smooth, planes.height, picture, guide, weights, planes, by_alpha, smoothed)
        guide, smoothed = smoothed, guide
    return as_codes(guide, planes, codes)


@kernel
def _smooth(
    first: int,
    last: int,
    picture: Array,
    guide: Array | None,
    weights: WeightExponents,
    planes: Planes,
    alpha: bool | None,
    smoothed: Array,
) -> None:
    """Smooth rows ``first`` .. ``last`` - 1 of ``picture`` over columns, then rows, among pixels alike in ``guide``.

    Without a guide all colours are alike. All three are rows of planes.
    """
    block = Planes(_ROWS, planes.width, planes.stride, planes.margin, planes.channels)
    size = _ROWS * planes.channels * (planes.stride + 2 * planes.margin)
    columns = np.empty(size, np.float32)  # the block, smoothed over columns
    for y0 in range(first, last, _ROWS):
        y_end = min(y0 + _ROWS, last)
        for tile in range(0, planes.stride, _COLUMNS):
            for y in range(y0, y_end):
                line, plane = row_of(y - y0, block)
                for x0 in range(tile, min(tile + _COLUMNS, planes.stride), LANES):
                    x = min(x0, planes.stride - LANES)
                    centre, sums = _over_column(picture, guide, weights, x, y, planes, alpha)
                    store_mean(sums, centre, columns, line + x, plane, alpha)
        for y in range(y0, y_end):
            repeat_borders(columns, y - y0, block)
            line, _ = row_of(y - y0, block)
            row, plane = row_of(y, planes)
            for x0 in range(0, planes.stride, LANES):
                x = min(x0, planes.stride - LANES)
                centre, sums = _over_row(columns, line + x, guide, row + x, weights, plane, alpha)
                store_mean(sums, centre, smoothed, row + x, plane, alpha)
            repeat_borders(smoothed, y, planes)


@inlined
def _over_column(
    picture: Array, guide: Array | None, weights: WeightExponents, x: int, y: int, planes: Planes, alpha: bool | None
) -> tuple[Color, Sums]:
    """Return sixteen pixels of row y from x on, and the sums over their columns."""
    spatial, range_exponent = weights
    row, plane = row_of(y, planes)
    centre, here = load_color(picture, row + x, plane, alpha), _load_guide(guide, row + x, plane)
    sums = start_sums(centre)
    for s in range(1, spatial.size):
        above, _ = row_of(max(y - s, 0), planes)
        below, _ = row_of(min(y + s, planes.height - 1), planes)
        for i in (above + x, below + x):
            exponent = spatial[s] + _alike(here, guide, i, plane, range_exponent)
            sums = _add(sums, centre, load_color(picture, i, plane, alpha), exponent, alpha)
    return centre, sums


@inlined
def _over_row(
    picture: Array, i: int, guide: Array | None, j: int, weights: WeightExponents, plane: int, alpha: bool | None
) -> tuple[Color, Sums]:
    """Return sixteen pixels, at i in ``picture`` and at j in ``guide``, and the sums over their rows."""
    spatial, range_exponent = weights
    centre, here = load_color(picture, i, plane, alpha), _load_guide(guide, j, plane)
    sums = start_sums(centre)
    for s in range(1, spatial.size):
        for dx in (-s, s):
            exponent = spatial[s] + _alike(here, guide, j + dx, plane, range_exponent)
            sums = _add(sums, centre, load_color(picture, i + dx, plane, alpha), exponent, alpha)
    return centre, sums


@inlined
def _load_guide(guide: Array | None, i: int, plane: int) -> Color:
    """Return the guide's colours of sixteen pixels; without a guide, nothing that is used."""
    if guide is None:
        nothing = splat_floats(0.0)
        return Color(nothing, nothing, nothing, nothing)
    there: Color = load_color(guide, i, plane, None)
    return there


@inlined
def _alike(here: Color, guide: Array | None, i: int, plane: int, range_exponent: float) -> Floats:
    """Return log2 of the range kernel between ``here`` and the guide's pixels from ``i`` on; 0 without a guide."""
    if guide is None:
        return splat_floats(0.0)
    there = load_color(guide, i, plane, None)
    l, a, b = there.l - here.l, there.a - here.a, there.b - here.b  # noqa: E741
    return (l * l + a * a + b * b) * range_exponent


@inlined
def _add(sums: Sums, centre: Color, there: Color, exponent: Floats, alpha: bool | None) -> Sums:
    """Return the sums with one more pixel of each centre, weighted by alpha 2^exponent."""
    weight = exp2_weight(exponent)
    if alpha is not None:
        weight = weight * there.alpha
    l, a, b = there.l - centre.l, there.a - centre.a, there.b - centre.b  # noqa: E741
    return Sums(sums.l + weight * l, sums.a + weight * a, sums.b + weight * b, sums.weight + weight)
