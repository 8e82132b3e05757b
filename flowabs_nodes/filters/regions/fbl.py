"""The flow-based bilateral filter (section 4.1): smooths along the flow, then across it, among similar colours."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.choices import SAMPLINGS
from flowabs_nodes.filters import validate
from flowabs_nodes.filters.regions.bilateral_line import pass_on_lines
from flowabs_nodes.filters.regions.range_weights import (
    Pass,
    add,
    closeness,
    color,
    falloff,
    floats_of,
    keep,
    kept,
    mean,
    on_records,
    only,
    partial_coverage,
    records_of,
)
from flowabs_nodes.filters.validate import Array
from flowabs_nodes.sampling.chain_code import follow, written_walks
from flowabs_nodes.sampling.coords import Frame, frame_of, padded
from flowabs_nodes.sampling.samples import expect, find, new_points, read, row_below
from flowabs_nodes.sampling.streamline import ALL, advance, column, expect_tangents, new_walks, set_out, turn
from flowabs_nodes.simd.bands import over_rows
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
) -> Array:
    """Flow-based bilateral filter, eqs. 12-14: C_e along the flow, then C_g across it, ``iterations`` times.

    Parameters
    ----------
    codes
        Code values, (H, W, 3), not multiplied by alpha. Colours differ by their Euclidean distance.
    flow
        (H, W, 2), unit tangents, x right and y down; the sign has no meaning.
    sigma_e, sigma_g
        Sigma of the Gaussian along and across the flow, in pixels, 0 to 10,000; 0 leaves that pass out. With nearest
        pixels walks of up to 16 steps (``sigma_e`` 5.3) are written down once, 8 bytes a pixel for each 8 steps.
    r_e, r_g
        Sigma of the Gaussian of colour differences along and across the flow, in code values, above 0 (eq. 13).
    iterations
        At least 0; 0 gives a copy.
    sampling
        How curve and gradient line are read, "nearest" pixel (crisper, faster) or "bilinear".
    alpha
        (H, W), coverage: every reading's weight is multiplied by its alpha, so that the colour of what is not there
        never shows. Pixels with alpha 0 or less keep their value. None is 1 everywhere.

    Returns
    -------
    The smoothed code values, (H, W, 3) float32.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    codes = validate.planes("codes", codes)
    flow = validate.flow_field(flow, codes.shape)
    sigma_e = validate.number("sigma_e", sigma_e, min=0, max=10_000)
    r_e = validate.number("r_e", r_e, above=0)
    sigma_g = validate.number("sigma_g", sigma_g, min=0, max=10_000)
    r_g = validate.number("r_g", r_g, above=0)
    iterations = validate.whole("iterations", iterations, min=0)
    bilinear = validate.choice("sampling", sampling, SAMPLINGS) == "bilinear"
    covered, frame = partial_coverage(alpha, codes), frame_of(codes)
    passes = []
    if sigma_e > 0 and iterations > 0:
        passes.append(_pass_along(flow, sigma_e, r_e, bilinear, covered, frame))
    if sigma_g > 0:
        passes.append(pass_on_lines(flow, True, None, sigma_g, r_g, bilinear, covered, frame))
    picture = records_of(codes, covered, frame)
    del codes  # their memory is free for the passes if nobody else holds them
    return on_records(picture, frame, passes, iterations)


def _pass_along(flow: Array, sigma: float, r: float, bilinear: bool, alpha: Array | None, frame: Frame) -> Pass:
    """C_e, eq. 12: along walks that are written down, where they can be."""
    tangents, near, like = padded(flow, frame).view(np.complex64), closeness(sigma), falloff(r)
    by_alpha = None if alpha is None else True
    moves = None if bilinear else written_walks(tangents, near.size - 1, frame)

    def smooth(picture: Array, smoothed: Array) -> None:
        if moves is not None:
            over_rows(_along_moves, frame.height, picture, moves, near, like, by_alpha, frame, smoothed)
        else:
            marks = True if bilinear else None, by_alpha
            over_rows(_along_walks, frame.height, picture, tangents, near, like, *marks, frame, smoothed)

    return smooth


@kernel
def _along_moves(
    first: int,
    last: int,
    picture: Any,
    moves: Any,
    closeness: Any,
    falloff: float,
    alpha: Any,
    frame: Frame,
    smoothed: Any,
) -> None:
    """Eq. 12 along walks that are written down, two times sixteen pixels at a time."""
    points, size, steps = new_points(), floats_of(alpha), closeness.size - 1
    below = row_below(frame, size)
    for y in range(first, last):
        for x0 in range(0, frame.stride, 2 * LANES):
            for block in range(2):
                x = min(x0 + block * LANES, frame.stride - LANES)
                expect(picture, smoothed, x, y, steps + 1, frame, size)
                follow(moves, steps, x, y, frame, size, points.place, block * 2 * steps * LANES)
            for block in range(2):
                pixel = y * frame.stride + min(x0 + block * LANES, frame.stride - LANES)
                centre = color(picture, pixel, alpha)
                sums = only(centre)
                for s in range(1, steps + 1):
                    for way in range(2):
                        at = (2 * (block * steps + s - 1) + way) * LANES
                        there = read(picture, below, points, at, None, alpha)
                        sums = add(sums, centre, there, closeness[s], falloff, alpha)
                mean(sums, centre, smoothed, pixel, alpha)


@kernel
def _along_walks(
    first: int,
    last: int,
    picture: Any,
    flow: Any,
    closeness: Any,
    falloff: float,
    bilinear: Any,
    alpha: Any,
    frame: Frame,
    smoothed: Any,
) -> None:
    """Eq. 12 along walks as they are taken."""
    walks, points, size, steps = new_walks(), new_points(), floats_of(alpha), closeness.size - 1
    so_far = scratch(np.float32, 16)  # the sums of four times sixteen pixels
    below = row_below(frame, size)
    for y in range(first, last):
        for x0 in range(0, frame.stride, ALL // 2):
            set_out(walks, flow, x0, y, frame)
            for at in range(0, ALL, 2 * LANES):
                x = column(x0, at, frame)
                expect(picture, smoothed, x, y, steps + 1, frame, size)
                expect_tangents(flow, x, y, steps + 1, frame)
                keep(so_far, at // (2 * LANES), only(color(picture, y * frame.stride + x, alpha)))
            for s in range(1, steps + 1):
                for at in range(0, ALL, LANES):
                    x = column(x0, at, frame)
                    advance(walks, at, x, y, frame)
                    find(points, at, load(walks.dx, at), load(walks.dy, at), x, y, frame, size, bilinear)
                for at in range(0, ALL, 2 * LANES):
                    centre = color(picture, y * frame.stride + column(x0, at, frame), alpha)
                    sums = kept(so_far, at // (2 * LANES))
                    for way in range(2):
                        there = read(picture, below, points, at + way * LANES, bilinear, alpha)
                        sums = add(sums, centre, there, closeness[s], falloff, alpha)
                    keep(so_far, at // (2 * LANES), sums)
                if s < steps:
                    turn(walks, flow)
            for at in range(0, ALL, 2 * LANES):
                pixel = y * frame.stride + column(x0, at, frame)
                mean(kept(so_far, at // (2 * LANES)), color(picture, pixel, alpha), smoothed, pixel, alpha)
