"""The flow-based bilateral filter (section 4.1): smooth along the flow, then across it, among similar colours."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array, Int32
from flowabs_nodes.choices import SAMPLINGS
from flowabs_nodes.filters import gaussian, validate
from flowabs_nodes.filters.flow.flow_resolution import reduced_flow
from flowabs_nodes.filters.regions.affine_upsampling import applied, fitted
from flowabs_nodes.filters.regions.bilateral_line import line_pass
from flowabs_nodes.filters.regions.range_weights import (
    Pass,
    Records,
    WeightExponents,
    add_sample,
    as_records,
    load_color,
    load_sums,
    partial_coverage,
    record_size,
    run_passes,
    start_sums,
    store_mean,
    store_sums,
    weight_exponents,
)
from flowabs_nodes.filters.working_scale import regions_factor, shortened_range
from flowabs_nodes.sampling.chain_code import decode_offsets, encode_streamlines
from flowabs_nodes.sampling.coords import Raster, padded_rows, raster_of
from flowabs_nodes.sampling.resolution import reduced
from flowabs_nodes.sampling.samples import (
    locate,
    new_sample_coords,
    prefetch_rows,
    row_below,
    sample,
)
from flowabs_nodes.sampling.streamline import (
    BATCH,
    advance,
    block_column,
    new_streamlines,
    prefetch_tangents,
    start,
    turn,
)
from flowabs_nodes.simd.bands import over_rows, thread_count
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.lanes import LANES
from flowabs_nodes.simd.memory import load, scratch


def fbl(
    codes: npt.ArrayLike,
    flow: npt.ArrayLike,
    sigma_e: float = 2.0,
    r_e: float = 10.0,
    sigma_g: float = 0.5,
    r_g: float = 10.0,
    iterations: int = 5,
    sampling: str = "nearest",
    alpha: npt.ArrayLike | None = None,
    working_scale: str = "full",
) -> Array:
    """Smooth a picture by eqs. 12-14: C_e along the flow, then C_g across it, ``iterations`` times.

    Both are bilateral filters in one dimension: weighted means of the colours at whole steps along the streamline c_x
    (C_e) or the gradient axis l_x (C_g), weighted by the distance along it and by the difference of colour.

    Parameters
    ----------
    codes
        Code values, (H, W, 3), not multiplied by alpha. Colours differ by their Euclidean distance.
    flow
        (H, W, 2), unit tangents, x right and y down; the sign has no meaning.
    sigma_e, sigma_g
        Sigma of the spatial kernel along and across the flow, in pixels, 0 to 10,000; 0 leaves that pass out. With
        nearest pixels, streamlines of up to 16 steps (``sigma_e`` 5.3) are encoded once, in 8 bytes a pixel for each
        8 steps.
    r_e, r_g
        Sigma of the range kernel along and across the flow (eq. 13), in code values, above 0.
    iterations
        At least 0; 0 gives a copy.
    sampling
        How the picture is sampled along streamlines and gradient axes: "nearest" pixel (crisper, faster) or "bilinear".
    alpha
        Coverage, (H, W). The weight of every sample is multiplied by its alpha, so that the colour of an uncovered
        pixel never shows. Pixels with alpha 0 or less keep their value. None is 1 everywhere.
    working_scale
        The size of the picture that is worked on: "full"; "1/2" or "1/4" of its width and height, sigmas to match, the
        result brought back up along the edges of ``codes``
        (:mod:`~flowabs_nodes.filters.regions.affine_upsampling`); or "auto": 1/2 where it leaves ``sigma_e`` at least 4
        pixels and ``sigma_g`` at least 2, each unless it is 0; 1/4 where it leaves twice as much.

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
    bilinear = validate.choice("sampling", sampling, SAMPLINGS) == "bilinear"
    covered, factor = partial_coverage(alpha, codes), regions_factor(working_scale, sigma_e, sigma_g)
    if factor > 1 and iterations > 0:
        share = None if covered is None else reduced(covered, factor)
        small, small_flow = reduced(codes, factor, covered), reduced_flow(flow, factor)
        sigmas, ranges = (sigma_e / factor, sigma_g / factor), [shortened_range(r, factor) for r in (r_e, r_g)]
        smoothed = fbl(small, small_flow, sigmas[0], ranges[0], sigmas[1], ranges[1], iterations, sampling, share)
        del small_flow
        lines = fitted(small, smoothed, share)
        del small, smoothed
        # Edges have their sharpness from the picture, and with it their grain: a short pass along them takes it out.
        return _along_edges(codes, lines, factor, flow, min(sigma_e, factor), r_e, bilinear, covered)

    raster = raster_of(codes)
    passes = []
    if sigma_e > 0 and iterations > 0:
        passes.append(_pass_along(flow, sigma_e, r_e, bilinear, covered, raster, again=iterations > 1))
    if sigma_g > 0:
        passes.append(line_pass(flow, True, None, sigma_g, r_g, bilinear, covered, raster))
    picture = as_records(codes, covered, raster)
    del codes  # gives the passes this memory if the caller does not hold it either
    return run_passes(picture, raster, passes, iterations)


def _along_edges(
    codes: Array, lines: Array, factor: int, flow: Array, sigma: float, r: float, bilinear: bool, alpha: Array | None
) -> Array:
    """Return the picture at full size (H, W, 3) that ``lines`` make of ``codes``, after a pass C_e.

    It is done in bands of rows with what the pass reads around them, so that little is held at full size.
    """
    if sigma == 0:
        return applied(lines, codes, factor, alpha)
    height, halo, step = codes.shape[0], gaussian.radius(sigma) + 1, 32 * max(4, thread_count())
    result = np.empty_like(codes)
    for first in range(0, height, step):
        last = min(first + step, height)
        top, bottom = max(first - halo, 0), min(last + halo, height)
        covered = None if alpha is None else alpha[top:bottom]
        band = applied(lines, codes, factor, alpha, top, bottom)
        raster = raster_of(band)
        along = _pass_along(flow[top:bottom], sigma, r, bilinear, covered, raster, again=False)
        smoothed = run_passes(as_records(band, covered, raster), raster, [along], 1)
        made, rows = result[first:last], smoothed[first - top : last - top]

        def copy(begin: int, end: int, made: Array = made, rows: Array = rows) -> None:
            made[begin:end] = rows[begin:end]

        over_rows(copy, last - first)
    return result


def _pass_along(
    flow: Array, sigma: float, r: float, bilinear: bool, alpha: Array | None, raster: Raster, *, again: bool
) -> Pass:
    """Return the pass C_e of eq. 12.

    Its streamlines are encoded once if they are short, sampled nearest, and followed ``again``.
    """
    tangents, weights = padded_rows(flow, raster).view(np.complex64), weight_exponents(sigma, r)
    by_alpha = None if alpha is None else True
    chain = None if bilinear or not again else encode_streamlines(tangents, weights.spatial.size - 1, raster)

    def smooth(values: Array, smoothed: Array) -> None:
        picture = Records(values, raster, by_alpha)
        if chain is not None:
            over_rows(_along_encoded, raster.height, picture, chain, weights, smoothed)
        else:
            over_rows(_along_flow, raster.height, picture, tangents, weights, True if bilinear else None, smoothed)

    return smooth


@kernel
def _along_encoded(
    first: int, last: int, picture: Records, chain: Int32, weights: WeightExponents, smoothed: Array
) -> None:
    """Smooth rows ``first`` .. ``last`` - 1 by eq. 12, over the streamlines of a chain code, sampled nearest.

    Two blocks of sixteen pixels take turns: one is decoded while the gathers of the other are under way.
    """
    values, raster, alpha = picture
    spatial, range_exponent = weights
    coords, size, steps = new_sample_coords(), record_size(alpha), spatial.size - 1
    below = row_below(raster, size)
    for y in range(first, last):
        for x0 in range(0, raster.stride, 2 * LANES):
            for block in range(2):
                x = min(x0 + block * LANES, raster.stride - LANES)
                prefetch_rows(values, smoothed, x, y, steps + 1, raster, size)
                decode_offsets(chain, steps, x, y, raster, size, coords.place, block * 2 * steps * LANES)
            for block in range(2):
                pixel = y * raster.stride + min(x0 + block * LANES, raster.stride - LANES)
                centre = load_color(values, pixel, alpha)
                sums = start_sums(centre)
                for s in range(1, steps + 1):
                    for way in range(2):  # c_x(s), c_x(-s)
                        at = (2 * (block * steps + s - 1) + way) * LANES
                        there = sample(values, below, coords, at, None, alpha)
                        sums = add_sample(sums, centre, there, spatial[s], range_exponent, alpha)  # eq. 12
                store_mean(sums, centre, smoothed, pixel, alpha)


@kernel
def _along_flow(
    first: int,
    last: int,
    picture: Records,
    flow: npt.NDArray[np.complex64],
    weights: WeightExponents,
    bilinear: bool | None,
    smoothed: Array,
) -> None:
    """Smooth rows ``first`` .. ``last`` - 1 by eq. 12, over streamlines that are integrated step by step.

    The streamlines of 64 pixels, both ways, are under way at once (:mod:`~flowabs_nodes.sampling.streamline`).
    ``flow`` is (H, stride) complex64, flattened; ``bilinear`` is True, or None for nearest pixels.
    """
    values, raster, alpha = picture
    spatial, range_exponent = weights
    curves, coords, size, steps = new_streamlines(), new_sample_coords(), record_size(alpha), spatial.size - 1
    so_far = scratch(np.float32, 16)  # the sums of four blocks of sixteen pixels
    below = row_below(raster, size)
    for y in range(first, last):
        for x0 in range(0, raster.stride, BATCH // 2):
            start(curves, flow, x0, y, raster)
            for at in range(0, BATCH, 2 * LANES):
                x = block_column(x0, at, raster)
                prefetch_rows(values, smoothed, x, y, steps + 1, raster, size)
                prefetch_tangents(flow, x, y, steps + 1, raster)
                store_sums(so_far, at // (2 * LANES), start_sums(load_color(values, y * raster.stride + x, alpha)))
            for s in range(1, steps + 1):
                for at in range(0, BATCH, LANES):
                    x = block_column(x0, at, raster)
                    advance(curves, at, x, y, raster)
                    locate(coords, at, (load(curves.dx, at), load(curves.dy, at)), x, y, raster, size, bilinear)
                for at in range(0, BATCH, 2 * LANES):
                    centre = load_color(values, y * raster.stride + block_column(x0, at, raster), alpha)
                    sums = load_sums(so_far, at // (2 * LANES))
                    for way in range(2):  # c_x(s), c_x(-s)
                        there = sample(values, below, coords, at + way * LANES, bilinear, alpha)
                        sums = add_sample(sums, centre, there, spatial[s], range_exponent, alpha)  # eq. 12
                    store_sums(so_far, at // (2 * LANES), sums)
                if s < steps:
                    turn(curves, flow)
            for at in range(0, BATCH, 2 * LANES):
                pixel = y * raster.stride + block_column(x0, at, raster)
                sums, centre = load_sums(so_far, at // (2 * LANES)), load_color(values, pixel, alpha)
                store_mean(sums, centre, smoothed, pixel, alpha)
