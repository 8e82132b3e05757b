"""The bilateral filter along a line or parabola through each pixel: eq. 14, and in Fig. 20 d and e also eq. 12."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array, Float64
from flowabs_nodes.filters.regions.range_weights import (
    Pass,
    Records,
    WeightExponents,
    add_sample,
    load_color,
    load_sums,
    record_size,
    start_sums,
    store_mean,
    store_sums,
    weight_exponents,
)
from flowabs_nodes.sampling.coords import Raster, padded_rows
from flowabs_nodes.sampling.samples import (
    PREFETCH_AHEAD,
    locate,
    locate_both_sides,
    new_sample_coords,
    prefetch_rows,
    row_below,
    sample,
)
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.lanes import LANES, to_doubles
from flowabs_nodes.simd.memory import load, load_pairs, prefetch, scratch

# The sample coordinates of so many blocks of sixteen pixels, at so many steps to each side, are computed before the
# first sample is gathered: gathers then need not wait for each other.
_BLOCKS, _STEPS = 4, 4


class Axis(NamedTuple):
    """The direction u of each pixel's line."""

    flow: npt.NDArray[np.complex64]  # (H, stride) complex64, flattened: unit tangents t
    across: bool  # u = (t.y, -t.x), the gradient axis l_x; else u = t


def line_pass(
    flow: Array,
    across: bool,
    kappa: npt.NDArray[np.float64] | None,
    sigma: float,
    r: float,
    bilinear: bool,
    alpha: Array | None,
    raster: Raster,
) -> Pass:
    """Return the pass over each pixel's line, at right angles to the flow (``across``) or along its tangent.

    Parameters
    ----------
    flow
        (H, W, 2), unit tangents.
    across
        Whether lines are gradient axes (eq. 14).
    kappa
        Curvatures per pixel, (H, W), which bend the lines into parabolas; None for straight lines.
    sigma, r
        Sigma of the spatial kernel in pixels, and of the range kernel in code values.
    bilinear
        Whether the picture is sampled bilinearly, else at the nearest pixel.
    alpha
        None where the records that the pass gets hold no alpha.
    raster
        The picture's.
    """
    axis = Axis(padded_rows(flow, raster).view(np.complex64), across)
    bends = None if kappa is None else padded_rows(kappa, raster)
    weights = weight_exponents(sigma, r)
    by_alpha, by_bilinear = None if alpha is None else True, True if bilinear else None

    def smooth(values: Array, smoothed: Array) -> None:
        picture = Records(values, raster, by_alpha)
        over_rows(_along_line, raster.height, picture, axis, bends, weights, by_bilinear, smoothed)

    return smooth


@kernel
def _along_line(
    first: int,
    last: int,
    picture: Records,
    axis: Axis,
    kappa: Float64 | None,
    weights: WeightExponents,
    bilinear: bool | None,
    smoothed: Array,
) -> None:
    """Smooth rows ``first`` .. ``last`` - 1 by the weighted mean over the points x + s u of each pixel x.

    With ``kappa``, (H, stride) float64 flattened, over the points x + s u + (kappa s^2 / 2) (-u.y, u.x). ``bilinear``
    is True, or None for nearest pixels.
    """
    values, raster, alpha = picture
    flow, across = axis
    spatial, range_exponent = weights
    coords, size, steps = new_sample_coords(), record_size(alpha), spatial.size - 1
    so_far, below = scratch(np.float32, 16), row_below(raster, size)  # the sums of each block
    for y in range(first, last):
        for x0 in range(0, raster.stride, _BLOCKS * LANES):
            for first_s in range(1, steps + 1, _STEPS):
                last_s = min(first_s + _STEPS, steps + 1)
                for block in range(_BLOCKS):
                    x = min(x0 + block * LANES, raster.stride - LANES)
                    pixel = y * raster.stride + x
                    tx, ty = load_pairs(flow, pixel)
                    if first_s == 1:
                        prefetch_rows(values, smoothed, x, y, steps + 1, raster, size)
                        prefetch(flow, pixel + PREFETCH_AHEAD)
                        prefetch(flow, pixel + PREFETCH_AHEAD + LANES // 2)
                    ux, uy = to_doubles(tx), to_doubles(ty)
                    if across:
                        ux, uy = uy, -ux
                    for s in range(first_s, last_s):
                        at = 2 * LANES * (block * _STEPS + s - first_s)
                        dx, dy = float(s) * ux, float(s) * uy
                        if kappa is None and bilinear is None:
                            locate_both_sides(coords, at, (dx, dy), x, y, raster, size)
                        elif kappa is None:
                            locate(coords, at, (dx, dy), x, y, raster, size, bilinear)
                            locate(coords, at + LANES, (-dx, -dy), x, y, raster, size, bilinear)
                        else:
                            bend = load(kappa, pixel) * (float(s) * float(s) / 2)
                            bx, by = -bend * uy, bend * ux
                            locate(coords, at, (bx + dx, by + dy), x, y, raster, size, bilinear)
                            locate(coords, at + LANES, (bx - dx, by - dy), x, y, raster, size, bilinear)
                for block in range(_BLOCKS):
                    pixel = y * raster.stride + min(x0 + block * LANES, raster.stride - LANES)
                    centre = load_color(values, pixel, alpha)
                    sums = start_sums(centre) if first_s == 1 else load_sums(so_far, block)
                    for s in range(first_s, last_s):
                        at = 2 * LANES * (block * _STEPS + s - first_s)
                        for side in range(2):  # l_x(s), l_x(-s)
                            there = sample(values, below, coords, at + side * LANES, bilinear, alpha)
                            sums = add_sample(sums, centre, there, spatial[s], range_exponent, alpha)  # eq. 14
                    if last_s <= steps:
                        store_sums(so_far, block, sums)
                    else:
                        store_mean(sums, centre, smoothed, pixel, alpha)
