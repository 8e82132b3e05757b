"""A bilateral filter along the line or parabola on which each pixel lies: eq. 14, and eq. 12 in Fig. 20 d and e."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
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
    only,
)
from flowabs_nodes.sampling.coords import Frame, padded
from flowabs_nodes.sampling.samples import AHEAD, expect, find, new_points, read, row_below
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.lanes import LANES, to_doubles
from flowabs_nodes.simd.memory import load, load_pairs, scratch, soon_read

_BLOCKS, _STEPS = 4, 4  # of sixteen pixels, and to each side, whose points are found before the first is read


def pass_on_lines(
    flow: Array,
    across: bool,
    kappa: npt.NDArray[np.float64] | None,
    sigma: float,
    r: float,
    bilinear: bool,
    alpha: Array | None,
    frame: Frame,
) -> Pass:
    """The pass at right angles to the flow, or along it over parabolas with curvatures ``kappa``, or over lines."""
    tangents = padded(flow, frame).view(np.complex64)
    bends = None if kappa is None else padded(kappa, frame)
    near, like = closeness(sigma), falloff(r)
    marks = True if bilinear else None, None if alpha is None else True

    def smooth(picture: Array, smoothed: Array) -> None:
        over_rows(_along_line, frame.height, picture, tangents, across, bends, near, like, *marks, frame, smoothed)

    return smooth


@kernel
def _along_line(
    first: int,
    last: int,
    picture: Any,
    flow: Any,
    across: bool,
    kappa: Any,
    closeness: Any,
    falloff: float,
    bilinear: Any,
    alpha: Any,
    frame: Frame,
    smoothed: Any,
) -> None:
    """Weighted means over the points x + s u, at right angles to the flow, u = (t.y, -t.x), or along it, u = t.

    With curvatures ``kappa``, not None, over x + s u + (kappa s^2 / 2) (-u.y, u.x).
    """
    points, size, steps = new_points(), floats_of(alpha), closeness.size - 1
    so_far, below = scratch(np.float32, 16), row_below(frame, size)  # the sums of four times sixteen pixels
    for y in range(first, last):
        for x0 in range(0, frame.stride, _BLOCKS * LANES):
            for first_s in range(1, steps + 1, _STEPS):
                last_s = min(first_s + _STEPS, steps + 1)
                for block in range(_BLOCKS):
                    x = min(x0 + block * LANES, frame.stride - LANES)
                    pixel = y * frame.stride + x
                    tx, ty = load_pairs(flow, pixel)
                    if first_s == 1:
                        expect(picture, smoothed, x, y, steps + 1, frame, size)
                        soon_read(flow, pixel + AHEAD)
                        soon_read(flow, pixel + AHEAD + LANES // 2)
                    ux, uy = to_doubles(tx), to_doubles(ty)
                    if across:
                        ux, uy = uy, -ux
                    for s in range(first_s, last_s):
                        at = 2 * LANES * (block * _STEPS + s - first_s)
                        dx, dy = float(s) * ux, float(s) * uy
                        if kappa is None:
                            find(points, at, dx, dy, x, y, frame, size, bilinear)
                            find(points, at + LANES, -dx, -dy, x, y, frame, size, bilinear)
                        else:
                            bend = load(kappa, pixel) * (float(s) * float(s) / 2)
                            bx, by = -bend * uy, bend * ux
                            find(points, at, bx + dx, by + dy, x, y, frame, size, bilinear)
                            find(points, at + LANES, bx - dx, by - dy, x, y, frame, size, bilinear)
                for block in range(_BLOCKS):
                    pixel = y * frame.stride + min(x0 + block * LANES, frame.stride - LANES)
                    centre = color(picture, pixel, alpha)
                    sums = only(centre) if first_s == 1 else kept(so_far, block)
                    for s in range(first_s, last_s):
                        at = 2 * LANES * (block * _STEPS + s - first_s)
                        for side in range(2):
                            there = read(picture, below, points, at + side * LANES, bilinear, alpha)
                            sums = add(sums, centre, there, closeness[s], falloff, alpha)
                    if last_s <= steps:
                        keep(so_far, block, sums)
                    else:
                        mean(sums, centre, smoothed, pixel, alpha)
