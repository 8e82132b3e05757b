"""Averages among similar colours (eqs. 12-14): what the flow-based and the oriented bilateral filters share.

Each pass is a weighted mean of readings along some line or curve through a pixel: weight alpha G(s) h, where G falls
with the distance s along the line and h, eq. 13, with the difference of colour from the pixel in the middle.

Pictures are records of three floats, L, a, b, or where there is an alpha of four, L, a, b, alpha. Kernels have an
argument ``alpha``, None or not, by which numba leaves out what does not happen. Behind the last record there is room
for two floats more: records are read four floats at a time, bilinearly eight.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters import gaussian, validate
from flowabs_nodes.sampling.coords import Raster, padded_rows
from flowabs_nodes.sampling.samples import TINY, Color
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.elementary import LOG2_E, exp2_weight
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, select, splat_floats
from flowabs_nodes.simd.memory import load, load_quads, load_triples, store, store_quads, store_triples

#: Fills its second argument from the first.
Pass = Callable[[Array, Array], Any]


def coverage(alpha: npt.ArrayLike | None, codes: Array) -> Array:
    """``alpha`` as (H, W), 1 everywhere where there is none."""
    if alpha is None:
        return np.broadcast_to(np.float32(1), codes.shape[:2])
    return validate.plane("alpha", alpha, codes.shape)


def partial_coverage(alpha: npt.ArrayLike | None, codes: Array) -> Array | None:
    """``alpha`` as (H, W); None where it is 1 everywhere."""
    if alpha is None:
        return None
    covered = validate.plane("alpha", alpha, codes.shape)
    return None if (covered == 1).all() else covered


def smooth_by_passes(codes: Array, alpha: Array | None, raster: Raster, passes: list[Pass], iterations: int) -> Array:
    """``codes`` after each of the passes in turn, ``iterations`` times."""
    return run_passes(as_records(codes, alpha, raster), raster, passes, iterations)


def as_records(codes: Array, alpha: Array | None, raster: Raster) -> Array:
    """A picture as kernels read it."""
    picture = np.empty(raster.height * raster.stride * (3 if alpha is None else 4) + 2, np.float32)
    picture[-2:] = 0
    given = padded_rows(codes, raster)
    if alpha is None:
        over_rows(lambda first, last: np.copyto(picture[first:last], given[first:last]), given.size)
    else:
        over_rows(_interleave_alpha, raster.height, given, padded_rows(alpha, raster), raster, picture)
    return picture


def run_passes(picture: Array, raster: Raster, passes: list[Pass], iterations: int) -> Array:
    """The code values that are left of a picture after the passes; its memory is theirs to write in."""
    pixels = raster.height * raster.stride
    smoothed = np.empty_like(picture)
    smoothed[-2:] = 0
    for _ in range(iterations):
        for smooth in passes:
            smooth(picture, smoothed)
            picture, smoothed = smoothed, picture
    if picture.size < 4 * pixels:
        result = picture[: 3 * pixels]
    else:
        result = smoothed[: 3 * pixels]  # its memory is free now
        over_rows(_drop_alpha, raster.height, picture, raster, result)
    return np.ascontiguousarray(result.reshape(raster.height, raster.stride, 3)[:, : raster.width])


@kernel
def _interleave_alpha(first: int, last: int, codes: Any, alpha: Any, raster: Raster, picture: Any) -> None:
    """Records of four from both; an alpha that is too little is none."""
    for y in range(first, last):
        for x in range(0, raster.stride, LANES):
            pixel = y * raster.stride + min(x, raster.stride - LANES)
            l, a, b = load_triples(codes, 3 * pixel)  # noqa: E741
            covered = load(alpha, pixel)
            store_quads(picture, 4 * pixel, (l, a, b, select(covered > TINY, covered, 0.0)))


@kernel
def _drop_alpha(first: int, last: int, picture: Any, raster: Raster, codes: Any) -> None:
    for y in range(first, last):
        for x in range(0, raster.stride, LANES):
            pixel = y * raster.stride + min(x, raster.stride - LANES)
            l, a, b, _ = load_quads(picture, 4 * pixel)  # noqa: E741
            store_triples(codes, 3 * pixel, (l, a, b))


def spatial_exponents(sigma: float) -> Array:
    """log2 G(0), G(1) .. to one side, without the constant factor."""
    steps = np.arange(gaussian.radius(sigma) + 1)
    return (-LOG2_E / 2 * (steps / max(sigma, 1e-6)) ** 2).astype(np.float32)


def range_exponent(r: float) -> np.float32:
    """log2 h for a colour difference of 1 (eq. 13), without the constant factor."""
    return np.float32(max(-LOG2_E / 2 / r / r, -1e30))


class Sums(NamedTuple):
    """The weighted sums of differences of colour from the centre, and the sum of weights.

    Sums of differences round less than sums of colours would, and constants stay exactly as they are.
    """

    l: Any  # noqa: E741
    a: Any
    b: Any
    weight: Any


@inlined
def record_size(alpha: Any) -> int:
    """In a record."""
    return 3 if alpha is None else 4


@inlined
def load_color(picture: Any, pixel: int, alpha: Any) -> Color:
    """Of ``pixel`` and the fifteen after it."""
    if alpha is None:
        l, a, b = load_triples(picture, 3 * pixel)  # noqa: E741
        return Color(l, a, b, splat_floats(1.0))
    l, a, b, covered = load_quads(picture, 4 * pixel)  # noqa: E741
    return Color(l, a, b, covered)


@inlined
def start_sums(centre: Color) -> Sums:
    """The centre, with its own alpha; its difference is 0."""
    nothing = splat_floats(0.0)
    return Sums(nothing, nothing, nothing, centre.alpha)


@inlined
def add_sample(
    sums: Sums, centre: Color, reading: Color, spatial_exponents: float, range_exponent: float, alpha: Any
) -> Sums:
    """And one reading for each pixel, with its weight alpha G h."""
    l, a, b = reading.l - centre.l, reading.a - centre.a, reading.b - centre.b  # noqa: E741
    weight = exp2_weight((l * l + a * a + b * b) * range_exponent + spatial_exponents)
    if alpha is not None:
        weight = weight * reading.alpha
    return Sums(sums.l + weight * l, sums.a + weight * a, sums.b + weight * b, sums.weight + weight)


@inlined
def store_sums(memory: Any, k: int, sums: Sums) -> None:
    """In scratch memory, as the k-th of others; :func:`load_sums` gives them back."""
    at = 4 * LANES * k
    store(memory, at, sums.l)
    store(memory, at + LANES, sums.a)
    store(memory, at + 2 * LANES, sums.b)
    store(memory, at + 3 * LANES, sums.weight)


@inlined
def load_sums(memory: Any, k: int) -> Sums:
    at = 4 * LANES * k
    return Sums(load(memory, at), load(memory, at + LANES), load(memory, at + 2 * LANES), load(memory, at + 3 * LANES))


@inlined
def store_mean(sums: Sums, centre: Color, smoothed: Any, pixel: int, alpha: Any) -> None:
    """Write the weighted mean; where alpha is 0 the colour stays what it was."""
    over = 1.0 / sums.weight
    if alpha is not None:
        over = select(centre.alpha > 0.0, over, 0.0)
    l, a, b = centre.l + over * sums.l, centre.a + over * sums.a, centre.b + over * sums.b  # noqa: E741
    if alpha is None:
        store_triples(smoothed, 3 * pixel, (l, a, b))
    else:
        store_quads(smoothed, 4 * pixel, (l, a, b, centre.alpha))
