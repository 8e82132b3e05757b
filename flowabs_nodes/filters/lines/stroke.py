"""Draw lines as an artist's pen does: short strokes are left out, long ones end in points."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array, Complex64
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import validate
from flowabs_nodes.filters.gaussian_blur import blur
from flowabs_nodes.filters.lines.stroke_lengths import smoothing
from flowabs_nodes.filters.lines.stroke_widths import Block, Rule, ink_columns, measure_across, weigh_widths
from flowabs_nodes.sampling.coords import Raster, padded_rows, raster_of
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.lanes import LANES, splat_ints
from flowabs_nodes.simd.memory import load, scratch, store

_ANY = np.float32(1e-30)  # the least ink that there is: a number that is not 0


def stroke(
    lines: npt.ArrayLike,
    flow: npt.ArrayLike,
    min_length: float = 0.0,
    taper: float = 0.0,
    strength: float = 0.0,
    response: npt.ArrayLike | None = None,
) -> Array:
    """Narrow the strokes of a drawing: those shorter than a length to nothing, all towards their ends.

    The pixels of ink of a stroke are found by walking along the flow (:mod:`.stroke_widths`). What comes of it is w, 0
    to 1, how wide the stroke shall be, as a part of its width W; it is averaged over the ink around a pixel. A pixel at
    a distance d from the middle of its line then keeps the share clamp(w (W / 2 + 1) - |d|, 0, 1) of its ink. W and d
    are measured across the flow, ink until there is paper.

    Parameters
    ----------
    lines
        (H, W), 1 paper and 0 ink, of any filter that draws lines.
    flow
        (H, W, 2), unit tangents, x right and y down; the sign has no meaning. The flow that the lines follow.
    min_length
        Length of strokes in pixels along the flow, 0 to 10,000: of a stroke of half this length nothing is left, half
        of the width of one of this length, all of one half as long again. 0 leaves none out.
    taper
        Over how many pixels a stroke grows from a point to its width, 0 to 10,000: with u the part of them that a pixel
        is away from the nearer end, the width is u (2 - u). 0 leaves ends blunt. A closed line has no end.
    strength
        Response in code values at which a stroke has its full width, at least 0: below, it is the narrower the weaker
        its response, in proportion. 0 has all strokes alike.
    response
        H, (H, W), of the filter that drew the lines: below 0 on lines. Needed with ``strength``.

    Returns
    -------
    Lines, (H, W) float32: no darker than ``lines``, and its very bits where a stroke keeps its width. Where all three
    are 0, a copy.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, a parameter out of range, or a strength alone.
    """
    lines = validate.plane("lines", lines)
    flow = validate.flow_field(flow, lines.shape)
    min_length = validate.number("min_length", min_length, min=0, max=10_000)
    taper = validate.number("taper", taper, min=0, max=10_000)
    strength = validate.number("strength", strength, min=0, max=1e6)
    if strength > 0 and response is None:
        raise ArgumentError("strength: needs the response of the lines", parameter="response")
    if min_length == taper == strength == 0:
        return lines.copy()
    raster = raster_of(lines)
    forces = np.empty(0, np.float32)
    if strength > 0 and response is not None:
        forces = padded_rows(validate.plane("response", response, lines.shape), raster)
    ink = padded_rows(np.clip(1 - lines, 0, 1), raster)
    tangents = padded_rows(flow, raster).view(np.complex64)
    rule = Rule.of(min_length, taper, strength)
    widths = _widths(ink, tangents, forces, raster, rule, smoothing(min_length, taper))
    narrowed = padded_rows(lines.copy(), raster)
    over_rows(_narrow, raster.height, ink, tangents, widths, raster, rule.reach, narrowed)
    return np.ascontiguousarray(narrowed.reshape(raster.height, raster.stride)[:, : raster.width])


def _widths(ink: Array, flow: Complex64, response: Array, raster: Raster, rule: Rule, sigma: float) -> Array:
    """Return w, averaged over the middles of strokes around each pixel, 1 where there is none.

    All pictures have their rows padded, and are flattened.
    """
    middle, weighted = np.empty_like(ink), np.empty_like(ink)
    over_rows(weigh_widths, raster.height, ink, flow, response, raster, rule, middle, weighted)
    shape = raster.height, raster.stride
    around = blur(middle.reshape(shape)[:, : raster.width], sigma)
    means = blur(weighted.reshape(shape)[:, : raster.width], sigma)
    np.divide(means, around, out=means, where=around > 0)
    means[around <= 0] = 1
    return padded_rows(means, raster)


@kernel
def _narrow(
    first: int, last: int, ink: Array, flow: Complex64, widths: Array, raster: Raster, reach: int, lines: Array
) -> None:
    """Narrow the strokes in the rows ``first`` .. ``last`` - 1 of ``lines`` to ``widths`` of their widths."""
    columns, place = np.empty(raster.stride + LANES, np.int32), scratch(np.int32, 1)
    sides = np.empty(2 * LANES, np.float32)
    for y in range(first, last):
        row = y * raster.stride
        count = ink_columns(ink, y, _ANY, raster, columns)
        for k in range(0, count, LANES):
            block = Block(load(columns, k), splat_ints(y))
            one_side, other_side = measure_across(ink, flow, block, reach, raster, place)
            store(sides, 0, one_side)
            store(sides, LANES, other_side)
            for lane in range(min(LANES, count - k)):
                at = row + columns[k + lane]
                one, other = sides[lane], sides[LANES + lane]
                half, off = (one + other + ink[at]) / 2, abs(one - other) / 2  # W / 2, |d|
                share = min(max(widths[at] * (half + 1) - off, 0), 1)
                lines[at] = lines[at] * share + (1 - share)
