"""Join two drawings of the same edges: one from passes, which is exact, and one from luminance, which sees more.

Luminance lines lie beside those of passes, a pixel or two away: the darker of both would be a double line. So a line of
passes clears the paper around it before the other drawing goes under it. With the ink a = 1 - lines, b = 1 - under,

    near(x) = smoothstep(1/5, 4/5, max over y of a(y) clamp(gap + 1/2 - |x - y|, 0, 1)),
    ink = max(a, b (1 - near)).

near is 1/2 at a distance of ``gap`` from full ink, and what is thin or faint clears as much as what is black. A line of
luminance that leads up to one of passes stops ``gap`` before it, which the eye does not see at 2.5 pixels.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters import halo, validate
from flowabs_nodes.sampling.coords import Raster, padded_rows, raster_of
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, Floats, any_lane, maximum, minimum, splat_floats
from flowabs_nodes.simd.memory import load, store

# Of the dilated ink: up to the first nothing is cleared, from the second on everything.
_FAINT, _FULL = np.float32(0.2), np.float32(0.8)


def join_lines(lines: npt.ArrayLike, under: npt.ArrayLike, gap: float = 2.5) -> Array:
    """Return one drawing of two, (H, W) float32: ``under`` shows where ``lines`` is paper far enough from its ink.

    Parameters
    ----------
    lines
        (H, W), 1 paper and 0 ink: the drawing on top, of which no ink is lost.
    under
        (H, W), 1 paper and 0 ink: the drawing that makes way.
    gap
        How far it makes way, 0 to 500 pixels; 0 gives the darker of both.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a gap out of range.
    """
    lines = validate.plane("lines", lines)
    under = validate.plane("under", under, lines.shape)
    gap = validate.number("gap", gap, min=0, max=500)
    raster, weights = raster_of(lines), cone(gap)
    joined = np.empty(raster.height * raster.stride, np.float32)
    over_rows(_join, raster.height, padded_rows(lines, raster), padded_rows(under, raster), raster, weights, joined)
    return np.ascontiguousarray(joined.reshape(raster.height, raster.stride)[:, : raster.width])


def cone(gap: float) -> Array:
    """Return clamp(gap + 1/2 - |x - y|, 0, 1) by the offset of y down and to the right; 0 without a gap."""
    away = np.arange(halo.join_lines(gap) + 1)
    weights = np.clip(gap + 0.5 - np.hypot(away[:, None], away), 0, 1) if gap > 0 else np.zeros((1, 1))
    return np.asarray(weights, np.float32)


@kernel
def _join(first: int, last: int, lines: Array, under: Array, raster: Raster, weights: Array, joined: Array) -> None:
    """Write the rows ``first`` .. ``last`` - 1 of both drawings together; all are (H, stride), flattened."""
    steps = weights.shape[0] - 1
    count = 2 * steps + 1
    ink = np.zeros((count, raster.stride + 2 * steps), np.float32)  # a, of the rows y - steps .. y + steps
    for y in range(first - steps, first + steps):
        _load_ink(lines, y, raster, steps, ink[y % count])
    for y in range(first, last):
        _load_ink(lines, y + steps, raster, steps, ink[(y + steps) % count])
        for x0 in range(0, raster.stride, LANES):
            x = min(x0, raster.stride - LANES)
            i = y * raster.stride + x
            over, below = load(lines, i), load(under, i)
            if weights[0, 0] > 0 and any_lane(below < over):  # elsewhere the darker one is that of passes
                t = minimum(maximum((_dilated(ink, y, x, weights) - _FAINT) / (_FULL - _FAINT), 0.0), 1.0)
                near = t * t * (3.0 - 2.0 * t)
                below = below + (1.0 - below) * near  # 1 - b (1 - near)
            store(joined, i, minimum(over, below))


@inlined
def _load_ink(lines: Array, y: int, raster: Raster, margin: int, ink: Array) -> None:
    """Write the ink of row y into ``ink``, from ``margin`` on; there is none beyond the picture."""
    ink[:] = 0
    if 0 <= y < raster.height:
        for x in range(raster.width):
            ink[margin + x] = min(max(1 - lines[y * raster.stride + x], np.float32(0.0)), np.float32(1.0))


@inlined
def _dilated(ink: Array, y: int, x: int, weights: Array) -> Floats:
    """Return the largest ink around the pixels x .. x + 15 of row y, weighted by its distance."""
    steps = weights.shape[0] - 1
    most = splat_floats(0.0)
    for v in range(-steps, steps + 1):
        row = ink[(y + v) % (2 * steps + 1)]
        for u in range(-steps, steps + 1):
            weight = weights[abs(v), abs(u)]
            if weight > 0:
                most = maximum(most, weight * load(row, x + steps + u))
    return most
