"""The gradient g of code values: tangents, magnitudes |g|, and the reference that magnitudes are normalised by.

The gradient is a 3x3 Sobel filter divided by 8, the border repeated. Inside it is float64: exact for any finite float32
picture, and squares neither overflow nor underflow.
"""

from __future__ import annotations

import re
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import validate
from flowabs_nodes.filters.gaussian_blur import blur
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.border import repeat_left, repeat_right
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import (
    LANES,
    absolute,
    from_doubles,
    maximum,
    minimum,
    select,
    splat_doubles,
    splat_floats,
    sqrt,
    to_doubles,
)
from flowabs_nodes.simd.memory import load, load_triples, store, store_pairs

_LARGEST = np.finfo(np.float32).max


class Gradient(NamedTuple):
    """Tangents and magnitudes of a picture, float32."""

    tangent: Array  # (H, W, 2): unit vectors (-g.y, g.x) / |g|, x then y, zero where there is no direction
    magnitude: Array  # (H, W): |g| in code values per pixel


class Measured(NamedTuple):
    """A gradient, and what is known of all its pixels."""

    gradient: Gradient
    largest: float  # magnitude
    everywhere: bool  # whether no tangent is zero


def gradient(code: Array, pre_blur: float = 0.0) -> Gradient:
    """Return the tangents and magnitudes of a picture.

    Parameters
    ----------
    code
        Code values, (H, W), or (H, W, C) for all channels together: g points along the major eigenvector of the
        structure tensor sum_k g_k g_k^T, |g| is the root of the major eigenvalue.
    pre_blur
        Sigma in pixels of a Gaussian blur of ``code`` before its gradient.
    """
    return measured(code, pre_blur).gradient


def measured(code: Array, pre_blur: float = 0.0) -> Measured:
    """Return the :func:`gradient` with its largest magnitude, and whether it has a tangent everywhere."""
    code = np.ascontiguousarray(blur(code, pre_blur) if pre_blur > 0 else code)
    height, width = code.shape[:2]
    if width < LANES:  # repeating the border changes no gradient but those of the columns that are cut off again
        wide = gradient(np.pad(code, [(0, 0), (0, LANES - width)] + [(0, 0)] * (code.ndim - 2), "edge"))
        narrow = Gradient(*(np.ascontiguousarray(made[:, :width]) for made in wide))
        return Measured(narrow, float(narrow.magnitude.max()), bool(narrow.tangent.any(axis=2).all()))
    made = Gradient(np.empty((height, width, 2), np.float32), np.empty((height, width), np.float32))
    channels = 1 if code.ndim == 2 else code.shape[2]
    tangent, magnitude = (each.reshape(-1) for each in made)
    bands = over_rows(_gradient, height, code.reshape(-1), channels, height, width, tangent, magnitude)
    return Measured(made, max(largest for largest, _ in bands), all(everywhere for _, everywhere in bands))


def masked(made: Measured, mask: Array) -> Measured:
    """Return a gradient whose magnitudes are multiplied by ``mask``, (H, W); where it is 0 there is no tangent."""
    tangent = np.where(mask[..., np.newaxis] > 0, made.gradient.tangent, np.float32(0))
    magnitude = made.gradient.magnitude * mask
    return Measured(Gradient(tangent, magnitude), float(magnitude.max()), made.everywhere and bool((mask > 0).all()))


def measure_reference(
    code: npt.ArrayLike,
    gradient_reference: str | float,
    pre_blur: float = 0.0,
    mask: npt.ArrayLike | None = None,
) -> float:
    """Return the number that ``gradient_reference`` comes to on this picture, in code values per pixel.

    Parameters
    ----------
    code
        Code values (H, W), or (H, W, 3) for all channels together.
    gradient_reference
        "max", a percentile over the picture such as "p99.5", or a number of at least 0, which is returned as it is.
    pre_blur
        Sigma of a Gaussian blur before the gradient, in pixels.
    mask
        What gradients are multiplied by, (H, W), 0 to 1; percentiles are of the pixels where it is above 0. None is 1
        everywhere.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a reference that is none of these.
    """
    code = validate.plane_or_planes("code", code)
    mask = None if mask is None else validate.matte("mask", mask, code.shape)
    pre_blur = validate.number("pre_blur", pre_blur, min=0, max=10_000)
    if _percentile(gradient_reference) is None:
        return float(gradient_reference)
    made = measured(code, pre_blur)
    return reference(made if mask is None else masked(made, mask), gradient_reference, mask)


def reference(made: Measured, gradient_reference: str | float, mask: Array | None = None) -> float:
    """Return the number that a valid ``gradient_reference`` comes to on this gradient, in code values per pixel.

    Percentiles are of the pixels where ``mask`` is above 0.
    """
    percent = _percentile(gradient_reference)
    if percent is None:
        return float(gradient_reference)
    if percent == 100 or made.largest == 0:
        return made.largest
    magnitude = made.gradient.magnitude
    return float(np.percentile(magnitude if mask is None else magnitude[mask > 0], percent))


def check_reference(gradient_reference: str | float) -> None:
    """Raise ArgumentError unless ``gradient_reference`` is "max", a percentile or a number of at least 0."""
    _percentile(gradient_reference)


def _percentile(reference: str | float) -> float | None:
    """Return 100 for "max", 99.5 for "p99.5", None for a number of at least 0; raise ArgumentError for others."""
    if not isinstance(reference, str):
        validate.number("gradient_reference", reference, min=0)
        return None
    if reference == "max":
        return 100.0
    match = re.fullmatch(r"p([0-9]+(\.[0-9]*)?)", reference, re.ASCII)
    if match is None or float(match[1]) > 100:
        raise ArgumentError(
            'gradient_reference: expected "max", a percentile from "p0" to "p100" such as "p99.5", or a number of at '
            f"least 0, found {reference!r}",
            parameter="gradient_reference",
        )
    return float(match[1])


@kernel
def _gradient(
    first: int, last: int, code: Array, channels: int, height: int, width: int, tangent: Array, magnitude: Array
) -> tuple[float, bool]:
    """Write the tangents and magnitudes of the rows ``first`` .. ``last`` - 1.

    All arrays are flattened: ``code`` (H, W, C), ``tangent`` (H, W, 2), ``magnitude`` (H, W); W is at least sixteen.
    Returns the largest magnitude of these rows, and whether each of their pixels has a tangent.
    """
    size = channels * (width + 2)
    rows = np.empty((3, size), np.float32)
    for y in range(first - 1, first + 1):
        _load_row(code, channels, height, width, y, rows[y % 3])
    largest, shortest = splat_floats(0.0), splat_floats(1.0)
    for y in range(first, last):
        _load_row(code, channels, height, width, y + 1, rows[(y + 1) % 3])
        above, here, below = rows[(y - 1) % 3], rows[y % 3], rows[(y + 1) % 3]
        for x0 in range(0, width, LANES):
            x = min(x0, width - LANES)
            if channels == 1:
                gx, gy = _sobel(above, here, below, x)
                tx, ty, m = _tangent_of(gx, gy)
            else:
                c, s, trace = splat_doubles(0.0), splat_doubles(0.0), splat_doubles(0.0)
                for i in range(x, size, width + 2):
                    gx, gy = _sobel(above, here, below, i)
                    xx, yy = gx * gx, gy * gy
                    c, s, trace = c + (xx - yy), s + 2.0 * (gx * gy), trace + (xx + yy)
                tx, ty, m = tangent_of_tensor(c, s, trace)
            i = y * width + x
            store_pairs(tangent, 2 * i, (tx, ty))
            store(magnitude, i, m)
            largest = maximum(largest, m)
            shortest = minimum(shortest, tx * tx + ty * ty)
    lanes = np.empty(2 * LANES, np.float32)
    store(lanes, 0, largest)
    store(lanes, LANES, shortest)
    for k in range(1, LANES):
        lanes[0] = max(lanes[0], lanes[k])
        lanes[LANES] = min(lanes[LANES], lanes[LANES + k])
    return lanes[0], lanes[LANES] > 0


@inlined
def _load_row(code: Array, channels: int, height: int, width: int, y: int, row: Array) -> None:
    """Write row y of each channel, with the border repeated once at either end, into ``row``, (C, W + 2) flattened.

    ``code`` is (H, W, C) flattened; a row outside the picture is the nearest row inside.
    """
    start = min(max(y, 0), height - 1) * width * channels
    columns = width + 2
    for x in range(0, width, LANES):
        i = min(x, width - LANES)
        if channels == 1:
            store(row, 1 + i, load(code, start + i))
        elif channels == 3:
            red, green, blue = load_triples(code, start + 3 * i)
            store(row, 1 + i, red)
            store(row, columns + 1 + i, green)
            store(row, 2 * columns + 1 + i, blue)
        else:
            for k in range(channels):
                for lane in range(i, i + LANES):
                    row[k * columns + 1 + lane] = code[start + lane * channels + k]
    for first in range(0, channels * columns, columns):
        repeat_left(row, first + 1, 1, 1)
        repeat_right(row, first + 1 + width, 1, 1)


@inlined
def _sobel(above: Array, here: Array, below: Array, i: int) -> Any:
    """Return g.x and g.y of sixteen pixels from three rows; item i of a row is the left neighbour of the first."""
    a, b, c = to_doubles(load(above, i)), to_doubles(load(above, i + 1)), to_doubles(load(above, i + 2))
    d, f = to_doubles(load(here, i)), to_doubles(load(here, i + 2))
    p, q, r = to_doubles(load(below, i)), to_doubles(load(below, i + 1)), to_doubles(load(below, i + 2))
    return ((c - a) + (r - p) + 2.0 * (f - d)) * 0.125, ((p - a) + (r - c) + 2.0 * (q - b)) * 0.125


@inlined
def _tangent_of(gx: Any, gy: Any) -> Any:
    """Return t.x, t.y and |g| for t = (-g.y, g.x) / |g|, zero where g is; float32 from float64."""
    size = sqrt(gx * gx + gy * gy)
    m = from_doubles(minimum(size, _LARGEST))
    inverse = select(m > 0.0, 1.0 / size, 0.0)
    return from_doubles(-gy * inverse), from_doubles(gx * inverse), m


@inlined
def tangent_of_tensor(c: Any, s: Any, trace: Any) -> Any:
    """Return t.x, t.y and |g| of a structure tensor of double angle (c, s), c = xx - yy and s = 2 xy, and ``trace``.

    The tangent is the major eigenvector turned by 90 degrees, |g| the root of the major eigenvalue.
    """
    m = from_doubles(minimum(sqrt((trace + sqrt(c * c + s * s)) * 0.5), _LARGEST))
    x, y = half_angle(c, s)
    return from_doubles(select(m > 0.0, -y, 0.0)), from_doubles(select(m > 0.0, x, 0.0)), m


@inlined
def half_angle(c: Any, s: Any) -> Any:
    """Return x and y of the unit vector at half the angle of (c, s), zero where (c, s) is zero.

    It is the major eigenvector of the symmetric matrix [[c, s], [s, -c]].
    """
    r = sqrt(c * c + s * s)
    large = sqrt((r + absolute(c)) * 0.5)
    small = 0.5 * s / large
    inverse = 1.0 / sqrt(r)
    x = select(c >= 0.0, large, small) * inverse
    y = select(c >= 0.0, small, large) * inverse
    return select(r > 0.0, x, 0.0), select(r > 0.0, y, 0.0)
