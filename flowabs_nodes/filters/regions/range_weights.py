"""Weighted means among similar colours (eqs. 12-14): what the flow-based and the oriented bilateral filters share.

Each pass replaces a pixel by the weighted mean of samples along a line or curve through this pixel, the centre. The
weight of a sample is alpha G(s) h: the spatial kernel G falls with the distance s along the line, the range kernel h
(eq. 13) with the difference of colour from the centre. Tomasi and Manduchi call the two closeness and similarity.

A picture is a 1-D array of records, (H, stride, 3) or (H, stride, 4) flattened: L, a, b, and alpha where there is one.
Two floats of padding follow the last record, because gathers read a record four floats at a time, and two neighbouring
records eight at a time. The argument ``alpha`` of a compiled kernel is True for records of four and None for records of
three; numba drops the branches that None rules out.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters import gaussian, validate
from flowabs_nodes.sampling.coords import Raster, padded_rows
from flowabs_nodes.sampling.samples import Color
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.elementary import LOG2_E, exp2_weight
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, select, splat_floats
from flowabs_nodes.simd.memory import load, load_quads, load_triples, store, store_quads, store_triples
from flowabs_nodes.simd.premultiplied import TINY

#: Smooths the records of its first argument and writes the result to its second.
Pass = Callable[[Array, Array], Any]


class Records(NamedTuple):
    """A picture to be smoothed, as one argument of a compiled kernel."""

    values: Array  # the 1-D array of records
    raster: Raster
    alpha: bool | None  # True where the records hold alpha, None where they do not


class WeightExponents(NamedTuple):
    """The logarithms to base 2 of the two kernels' weights, so that their product is one power of two."""

    spatial: Array  # (steps + 1,) float32: log2 G(s) of s = 0, 1 .. steps
    range: np.float32  # float32: log2 h per squared colour difference


def weight_exponents(sigma: float, r: float) -> WeightExponents:
    """Return the exponents of a spatial kernel of ``sigma`` pixels and a range kernel of ``r`` code values."""
    return WeightExponents(spatial_exponents(sigma), range_exponent(r))


def partial_coverage(alpha: npt.ArrayLike | None, codes: Array) -> Array | None:
    """Return ``alpha``, checked, as (H, W) float32; None where it is None or 1 in every pixel."""
    if alpha is None:
        return None
    covered = validate.plane("alpha", alpha, codes.shape)
    return None if (covered == 1).all() else covered


def smooth_by_passes(codes: Array, alpha: Array | None, raster: Raster, passes: list[Pass], iterations: int) -> Array:
    """Return code values (H, W, 3) after each of the passes in turn, ``iterations`` times; ``alpha`` is (H, W)."""
    return run_passes(as_records(codes, alpha, raster), raster, passes, iterations)


def as_records(codes: Array, alpha: Array | None, raster: Raster) -> Array:
    """Return code values (H, W, 3), and alpha (H, W) if there is one, as a 1-D array of records with its padding."""
    picture = np.empty(raster.height * raster.stride * (3 if alpha is None else 4) + 2, np.float32)
    picture[-2:] = 0
    given = padded_rows(codes, raster)
    if alpha is None:
        row = 3 * raster.stride

        def copy(first: int, last: int) -> None:
            picture[first * row : last * row] = given[first * row : last * row]

        over_rows(copy, raster.height)
    else:
        over_rows(_interleave_alpha, raster.height, given, padded_rows(alpha, raster), raster, picture)
    return picture


def run_passes(picture: Array, raster: Raster, passes: list[Pass], iterations: int) -> Array:
    """Return the code values (H, W, 3) of a picture of records after the passes, which write to its memory as well."""
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
        result = smoothed[: 3 * pixels]  # scratch memory, free after the last pass
        over_rows(_drop_alpha, raster.height, picture, raster, result)
    return np.ascontiguousarray(result.reshape(raster.height, raster.stride, 3)[:, : raster.width])


@kernel
def _interleave_alpha(first: int, last: int, codes: Array, alpha: Array, raster: Raster, picture: Array) -> None:
    """Write rows ``first`` .. ``last`` - 1 of records of four; an alpha that is too small to divide by becomes 0.

    ``codes`` is (H, stride, 3) and ``alpha`` (H, stride), both flattened.
    """
    for y in range(first, last):
        for x in range(0, raster.stride, LANES):
            pixel = y * raster.stride + min(x, raster.stride - LANES)
            l, a, b = load_triples(codes, 3 * pixel)  # noqa: E741
            covered = load(alpha, pixel)
            store_quads(picture, 4 * pixel, (l, a, b, select(covered > TINY, covered, 0.0)))


@kernel
def _drop_alpha(first: int, last: int, picture: Array, raster: Raster, codes: Array) -> None:
    """Write the colours of rows ``first`` .. ``last`` - 1 of records of four to ``codes``, (H, stride, 3) flattened."""
    for y in range(first, last):
        for x in range(0, raster.stride, LANES):
            pixel = y * raster.stride + min(x, raster.stride - LANES)
            l, a, b, _ = load_quads(picture, 4 * pixel)  # noqa: E741
            store_triples(codes, 3 * pixel, (l, a, b))


def spatial_exponents(sigma: float) -> Array:
    """Return log2 G(s) of the steps s = 0, 1 .. ceil(3 sigma), float32, without G's constant factor."""
    steps = np.arange(gaussian.radius(sigma) + 1)
    return (-LOG2_E / 2 * (steps / max(sigma, 1e-6)) ** 2).astype(np.float32)


def range_exponent(r: float) -> np.float32:
    """Return log2 h (eq. 13) of a colour difference of 1, without h's constant factor; ``r`` is in code values."""
    return np.float32(max(-LOG2_E / 2 / r / r, -1e30))


class Sums(NamedTuple):
    """The numerator and the denominator of the weighted mean, for each of sixteen centres.

    The numerator sums differences of colour from the centre: they round less than colours would, and a constant
    picture stays exactly what it is.
    """

    l: Any  # noqa: E741
    a: Any
    b: Any
    weight: Any


@inlined
def record_size(alpha: bool | None) -> int:
    """Return the number of floats in a record."""
    return 3 if alpha is None else 4


@inlined
def load_color(picture: Array, pixel: int, alpha: bool | None) -> Color:
    """Return the colours of ``pixel`` and of the fifteen pixels after it."""
    if alpha is None:
        l, a, b = load_triples(picture, 3 * pixel)  # noqa: E741
        return Color(l, a, b, splat_floats(1.0))
    l, a, b, covered = load_quads(picture, 4 * pixel)  # noqa: E741
    return Color(l, a, b, covered)


@inlined
def start_sums(centre: Color) -> Sums:
    """Return the sums of the centre alone: its difference from itself is 0, its weight is its alpha."""
    nothing = splat_floats(0.0)
    return Sums(nothing, nothing, nothing, centre.alpha)


@inlined
def add_sample(
    sums: Sums, centre: Color, there: Color, spatial_exponent: float, range_exponent: float, alpha: bool | None
) -> Sums:
    """Return the sums with one more sample of each centre, weighted by alpha G(s) h.

    ``spatial_exponent`` is log2 G(s) of the sample's step, ``range_exponent`` that of :func:`range_exponent`.
    """
    l, a, b = there.l - centre.l, there.a - centre.a, there.b - centre.b  # noqa: E741
    weight = exp2_weight((l * l + a * a + b * b) * range_exponent + spatial_exponent)  # eq. 13: h, times G(s)
    if alpha is not None:
        weight = weight * there.alpha
    return Sums(sums.l + weight * l, sums.a + weight * a, sums.b + weight * b, sums.weight + weight)


@inlined
def store_sums(memory: Array, k: int, sums: Sums) -> None:
    """Write sums to scratch memory (float32), as the k-th of several; :func:`load_sums` returns them."""
    at = 4 * LANES * k
    store(memory, at, sums.l)
    store(memory, at + LANES, sums.a)
    store(memory, at + 2 * LANES, sums.b)
    store(memory, at + 3 * LANES, sums.weight)


@inlined
def load_sums(memory: Array, k: int) -> Sums:
    """Return the k-th sums that :func:`store_sums` wrote to ``memory``."""
    at = 4 * LANES * k
    return Sums(load(memory, at), load(memory, at + LANES), load(memory, at + 2 * LANES), load(memory, at + 3 * LANES))


@inlined
def store_mean(sums: Sums, centre: Color, smoothed: Array, pixel: int, alpha: bool | None) -> None:
    """Write the weighted means of sixteen pixels, from ``pixel`` on; where alpha is 0 the colour stays the centre's."""
    over = 1.0 / sums.weight
    if alpha is not None:
        over = select(centre.alpha > 0.0, over, 0.0)
    l, a, b = centre.l + over * sums.l, centre.a + over * sums.a, centre.b + over * sums.b  # noqa: E741
    if alpha is None:
        store_triples(smoothed, 3 * pixel, (l, a, b))
    else:
        store_quads(smoothed, 4 * pixel, (l, a, b, centre.alpha))
