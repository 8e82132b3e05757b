"""A bilateral filter along the line or parabola on which each pixel lies: eq. 14, and eq. 12 in Fig. 20 d and e."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.filters.arguments import Array
from flowabs_nodes.filters.kernels import kernel
from flowabs_nodes.filters.points import Frame, padded
from flowabs_nodes.filters.readings import MOST, around, expect, find, new_points, read
from flowabs_nodes.filters.similarity import Pass, add, closeness, color, falloff, floats_of, mean, only
from flowabs_nodes.filters.threads import over_rows
from flowabs_nodes.filters.vector import LANES, load, load_pairs, to_doubles


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
    pictures = around(picture, frame, size)
    for y in range(first, last):
        for x0 in range(0, frame.stride, LANES):
            x = min(x0, frame.stride - LANES)
            pixel = y * frame.stride + x
            expect(picture, smoothed, x, y, steps + 1, frame, size)
            tx, ty = load_pairs(flow, pixel)
            ux, uy = to_doubles(tx), to_doubles(ty)
            if across:
                ux, uy = uy, -ux
            centre = color(picture, pixel, alpha)
            sums = only(centre)
            for first_s in range(1, steps + 1, MOST // 2):
                readings = 2 * min(MOST // 2, steps + 1 - first_s)
                for k in range(readings):
                    s = float((first_s + k // 2) * (1 - 2 * (k % 2)))  # 1, -1, 2, -2 ..
                    dx, dy = s * ux, s * uy
                    if kappa is not None:
                        bend = load(kappa, pixel) * (s * s / 2)
                        dx, dy = dx - bend * uy, dy + bend * ux
                    find(points, LANES * k, dx, dy, x, y, frame, size, bilinear)
                for k in range(readings):
                    there = read(pictures, points, LANES * k, bilinear, alpha)
                    sums = add(sums, centre, there, closeness[first_s + k // 2], falloff, alpha)
            mean(sums, centre, smoothed, pixel, alpha)
