"""A bilateral filter along the line or parabola on which each pixel lies: eq. 14, and eq. 12 in Fig. 20 d and e."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters.regions.range_weights import (
    Pass,
    add_sample,
    load_color,
    load_sums,
    range_exponent,
    record_size,
    spatial_exponents,
    start_sums,
    store_mean,
    store_sums,
)
from flowabs_nodes.sampling.coords import Raster, padded_rows
from flowabs_nodes.sampling.samples import PREFETCH_AHEAD, locate, new_sample_coords, prefetch_rows, row_below, sample
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.lanes import LANES, to_doubles
from flowabs_nodes.simd.memory import load, load_pairs, prefetch, scratch

_BLOCKS, _STEPS = 4, 4  # of sixteen pixels, and to each side, whose points are found before the first is read


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
    """The pass at right angles to the flow, or along it over parabolas with curvatures ``kappa``, or over lines."""
    tangents = padded_rows(flow, raster).view(np.complex64)
    bends = None if kappa is None else padded_rows(kappa, raster)
    near, like = spatial_exponents(sigma), range_exponent(r)
    marks = True if bilinear else None, None if alpha is None else True

    def smooth(picture: Array, smoothed: Array) -> None:
        over_rows(_along_line, raster.height, picture, tangents, across, bends, near, like, *marks, raster, smoothed)

    return smooth


@kernel
def _along_line(
    first: int,
    last: int,
    picture: Any,
    flow: Any,
    across: bool,
    kappa: Any,
    spatial_exponents: Any,
    range_exponent: float,
    bilinear: Any,
    alpha: Any,
    raster: Raster,
    smoothed: Any,
) -> None:
    """Weighted means over the points x + s u, at right angles to the flow, u = (t.y, -t.x), or along it, u = t.

    With curvatures ``kappa``, not None, over x + s u + (kappa s^2 / 2) (-u.y, u.x).
    """
    coords, size, steps = new_sample_coords(), record_size(alpha), spatial_exponents.size - 1
    so_far, below = scratch(np.float32, 16), row_below(raster, size)  # the sums of four times sixteen pixels
    for y in range(first, last):
        for x0 in range(0, raster.stride, _BLOCKS * LANES):
            for first_s in range(1, steps + 1, _STEPS):
                last_s = min(first_s + _STEPS, steps + 1)
                for block in range(_BLOCKS):
                    x = min(x0 + block * LANES, raster.stride - LANES)
                    pixel = y * raster.stride + x
                    tx, ty = load_pairs(flow, pixel)
                    if first_s == 1:
                        prefetch_rows(picture, smoothed, x, y, steps + 1, raster, size)
                        prefetch(flow, pixel + PREFETCH_AHEAD)
                        prefetch(flow, pixel + PREFETCH_AHEAD + LANES // 2)
                    ux, uy = to_doubles(tx), to_doubles(ty)
                    if across:
                        ux, uy = uy, -ux
                    for s in range(first_s, last_s):
                        at = 2 * LANES * (block * _STEPS + s - first_s)
                        dx, dy = float(s) * ux, float(s) * uy
                        if kappa is None:
                            locate(coords, at, dx, dy, x, y, raster, size, bilinear)
                            locate(coords, at + LANES, -dx, -dy, x, y, raster, size, bilinear)
                        else:
                            bend = load(kappa, pixel) * (float(s) * float(s) / 2)
                            bx, by = -bend * uy, bend * ux
                            locate(coords, at, bx + dx, by + dy, x, y, raster, size, bilinear)
                            locate(coords, at + LANES, bx - dx, by - dy, x, y, raster, size, bilinear)
                for block in range(_BLOCKS):
                    pixel = y * raster.stride + min(x0 + block * LANES, raster.stride - LANES)
                    centre = load_color(picture, pixel, alpha)
                    sums = start_sums(centre) if first_s == 1 else load_sums(so_far, block)
                    for s in range(first_s, last_s):
                        at = 2 * LANES * (block * _STEPS + s - first_s)
                        for side in range(2):
                            there = sample(picture, below, coords, at + side * LANES, bilinear, alpha)
                            sums = add_sample(sums, centre, there, spatial_exponents[s], range_exponent, alpha)
                    if last_s <= steps:
                        store_sums(so_far, block, sums)
                    else:
                        store_mean(sums, centre, smoothed, pixel, alpha)
