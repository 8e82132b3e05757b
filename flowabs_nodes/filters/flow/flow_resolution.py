"""Flows of reduced pictures: a flow reduced, and one brought back up, as the double angles (cos 2θ, sin 2θ).

A tangent and its opposite are the same direction; their double angles are the same vector, so means and weighted sums
of those are what means of directions should be. The result is at half the angle of the sum.
"""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array, Complex64
from flowabs_nodes.filters.flow.gradient import half_angle
from flowabs_nodes.sampling.resolution import (
    Enlargement,
    cubic_phases,
    enlarge_row,
    means_of_columns,
    new_column,
    planes_to_enlarge,
)
from flowabs_nodes.sampling.tile_cache import pad_width
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.border import repeat_right
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.lanes import LANES, any_lane, from_doubles, select, splat_doubles, to_doubles
from flowabs_nodes.simd.memory import load, load_pairs, store, store_pairs


def reduced_flow(flow: Array, factor: int) -> Array:
    """Return the mean direction of each block of a flow (H, W, 2), (h, w, 2); zero where a block has none."""
    if factor == 1:
        return flow
    height, width = flow.shape[:2]
    size = -(-height // factor), -(-width // factor)
    tangents = pad_width(flow, 1).view(np.complex64)[..., 0]
    small = np.empty((size[0], max(size[1], LANES), 2), np.float32)
    over_rows(_reduce_flow, size[0], tangents, width, factor, size[1], small.reshape(size[0], -1))
    return np.ascontiguousarray(small[:, : size[1]])


class Flows:
    """A flow on the picture that is worked on, and on smaller ones: each is made when it is first asked for, and kept.

    What looks at the same flow at the same size shares one of them.
    """

    def __init__(self, flow: Array) -> None:
        self._made = {1: flow}

    def reduced(self, factor: int) -> Array:
        """Return the :func:`reduced_flow`; for a ``factor`` of 1 the flow itself."""
        if factor not in self._made:
            self._made[factor] = reduced_flow(self._made[1], factor)
        return self._made[factor]


@kernel
def _reduce_flow(first: int, last: int, flow: Complex64, width: int, factor: int, across: int, small: Array) -> None:
    """Write rows ``first`` .. ``last`` - 1 of the mean directions of ``across`` blocks each, as pairs of a row.

    ``flow`` has (H, stride) tangents, of which the first ``width`` of a row are its own.
    """
    (height, stride), blocks = flow.shape, max(across, LANES)
    columns, means = np.zeros((2, max(stride, factor * blocks))), np.empty((2, blocks, 1))
    for j in range(first, last):
        for x0 in range(0, stride, LANES):
            x, c, s = min(x0, stride - LANES), splat_doubles(0.0), splat_doubles(0.0)
            for dy in range(factor):
                tx, ty = load_pairs(flow[min(factor * j + dy, height - 1)], x)
                tx, ty = to_doubles(tx), to_doubles(ty)
                length = tx * tx + ty * ty
                over = select(length > 0.0, 1.0 / length, 0.0)
                c, s = c + (tx * tx - ty * ty) * over, s + 2.0 * tx * ty * over
            store(columns[0], x, c)
            store(columns[1], x, s)
        for k in range(2):
            repeat_right(columns[k], width, factor * across - width, 1)
            means_of_columns(columns[k], factor, means[k])
        for x0 in range(0, blocks, LANES):
            x = min(x0, blocks - LANES)
            tx, ty = half_angle(load(means[0, :, 0], x), load(means[1, :, 0], x))
            store_pairs(small[j], 2 * x, (from_doubles(tx), from_doubles(ty)))


@kernel
def _double(first: int, last: int, flow: Array, doubled: Array) -> None:
    """Write cos 2θ and sin 2θ of the tangents in rows ``first`` .. ``last`` - 1, of any length; 0 where it is 0."""
    for y in range(first, last):
        for x in range(flow.shape[1]):
            tx, ty = np.float64(flow[y, x, 0]), np.float64(flow[y, x, 1])
            length = tx * tx + ty * ty
            over = 1.0 / length if length > 0 else 0.0
            doubled[0, y, x] = (tx * tx - ty * ty) * over
            doubled[1, y, x] = 2.0 * tx * ty * over


def enlarged_flow(flow: Array, factor: int, height: int, width: int) -> Array:
    """Return a flow of a reduced picture, (h, w, 2), brought up to (height, width, 2), unit tangents.

    Zero tangents count for nothing; where all around are zero the result is zero.
    """
    if factor == 1:
        return flow
    doubled = np.empty((2, *flow.shape[:2]), np.float32)
    over_rows(_double, flow.shape[0], flow, doubled)
    small, how = planes_to_enlarge(doubled, cubic_phases(factor))
    large = np.empty((height, max(width, LANES), 2), np.float32)
    over_rows(_enlarge_flow, height, small, how, flow, large.reshape(-1), large.shape[1])
    return np.ascontiguousarray(large[:, :width])


@kernel
def _enlarge_flow(
    first: int, last: int, doubled: Array, how: Enlargement, flow: Array, large: Array, stride: int
) -> None:
    """Write rows ``first`` .. ``last`` - 1 of a flow brought up; ``large`` is (H, stride, 2), flattened."""
    column, c = new_column(how), np.empty(how.factor * how.stride, np.float32)
    s = np.empty_like(c)
    for y in range(first, last):
        enlarge_row(doubled[0], y, how, column, c)
        enlarge_row(doubled[1], y, how, column, s)
        for x0 in range(0, stride, LANES):
            x = min(x0, stride - LANES)
            cos, sin = to_doubles(load(c, x)), to_doubles(load(s, x))
            tx, ty = half_angle(cos, sin)
            store_pairs(large, 2 * (y * stride + x), (from_doubles(tx), from_doubles(ty)))
            if any_lane((cos == 0.0) & (sin == 0.0)):  # opposite double angles, or no tangent: that of the block
                for lane in range(x, min(x + LANES, how.factor * how.width)):
                    if c[lane] == 0 and s[lane] == 0:
                        there = flow[min(y // how.factor, flow.shape[0] - 1), lane // how.factor]
                        large[2 * (y * stride + lane)], large[2 * (y * stride + lane) + 1] = there[0], there[1]
