"""The gradient of code values: tangents, magnitudes, and the reference that magnitudes are normalised by.

3x3 Sobel divided by 8, border repeated, in float64 inside: exact for any finite float32 picture, and never over- or
underflowing where it is squared.
"""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numba import prange

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import arguments
from flowabs_nodes.filters.arguments import Array
from flowabs_nodes.filters.blur import blur
from flowabs_nodes.filters.kernels import kernel, parallel_kernel

Float64 = npt.NDArray[np.float64]

_LARGEST = np.finfo(np.float32).max


class Gradient(NamedTuple):
    """``tangent`` (H, W, 2): unit vectors (-g.y, g.x)/|g|, zero where there is no direction; ``magnitude`` (H, W)."""

    tangent: Array
    magnitude: Array


def gradient(code: Array, pre_blur: float = 0.0) -> Gradient:
    """The tangent and |g|, in code values per pixel, of ``code``: (H, W), or (H, W, C) for all channels together.

    Together means the structure tensor sum_k g_k g_k^T: g points along its major eigenvector, |g| is the root of the
    major eigenvalue. ``pre_blur`` is the sigma of a Gaussian blur before, in pixels.
    """
    code = blur(code, pre_blur) if pre_blur > 0 else code
    height, width = code.shape[:2]
    tangent = np.empty((height, width, 2), np.float32)
    magnitude = np.empty((height, width), np.float32)
    channels = 1 if code.ndim == 2 else code.shape[2]
    _gradient(code.reshape(height, -1), channels, tangent, magnitude)
    return Gradient(tangent, magnitude)


def measure_reference(code: npt.ArrayLike, gradient_reference: str | float, pre_blur: float = 0.0) -> float:
    """What ``gradient_reference`` comes to on this picture, in code values per pixel.

    Parameters
    ----------
    code
        Code values (H, W), or (H, W, 3) for all channels together.
    gradient_reference
        "max", a percentile over the picture such as "p99.5", or a number of at least 0, which comes back as it is.
    pre_blur
        Sigma of a Gaussian blur before the gradient, in pixels.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a reference that is none of these.
    """
    code = arguments.plane_or_planes("code", code)
    pre_blur = arguments.number("pre_blur", pre_blur, min=0, max=10_000)
    percent = _percentile(gradient_reference)
    if percent is None:
        return float(gradient_reference)
    return _percentile_of(gradient(code, pre_blur).magnitude, percent)


def normalised(magnitude: Array, gradient_reference: str | float) -> Array:
    """ĝ = min(|g| / reference, 1); 0 everywhere if the reference is 0."""
    percent = _percentile(gradient_reference)
    reference = float(gradient_reference) if percent is None else _percentile_of(magnitude, percent)
    if reference == 0:
        return np.zeros_like(magnitude)
    strength = np.empty_like(magnitude)
    _normalised(magnitude, reference, strength)
    return strength


def check_reference(gradient_reference: str | float) -> None:
    """Raise ArgumentError unless ``gradient_reference`` is "max", a percentile or a number of at least 0."""
    _percentile(gradient_reference)


def _percentile(reference: str | float) -> float | None:
    """100 for "max", 99.5 for "p99.5", None for a number."""
    if not isinstance(reference, str):
        arguments.number("gradient_reference", reference, min=0)
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


def _percentile_of(magnitude: Array, percent: float) -> float:
    return float(magnitude.max() if percent == 100 else np.percentile(magnitude, percent))


@parallel_kernel
def _normalised(magnitude: Array, reference: float, strength: Array) -> None:
    for y in prange(magnitude.shape[0]):
        for x in range(magnitude.shape[1]):
            strength[y, x] = min(magnitude[y, x] / reference, 1.0)


@parallel_kernel
def _gradient(rows: Array, channels: int, tangent: Array, magnitude: Array) -> None:
    """``rows``: the picture's rows, channels side by side."""
    height, size = rows.shape
    for y in prange(height):
        smooth = np.empty(size + 2 * channels)  # (1 2 1) down the columns
        steep = np.empty(size + 2 * channels)  # (-1 0 1) down the columns
        _down(rows[max(y - 1, 0)], rows[y], rows[min(y + 1, height - 1)], channels, smooth, steep)
        gx, gy = np.empty(size), np.empty(size)
        _across(smooth[:size], smooth[2 * channels :], steep[:size], steep[channels:], steep[2 * channels :], gx, gy)
        if channels == 1:
            _tangents(gx, gy, tangent[y], magnitude[y])
        else:
            _tangents_together(gx, gy, channels, tangent[y], magnitude[y])


@kernel
def _down(above: Array, row: Array, below: Array, channels: int, smooth: Float64, steep: Float64) -> None:
    size = row.size
    for i in range(size):
        a, b, c = np.float64(above[i]), np.float64(row[i]), np.float64(below[i])
        smooth[channels + i] = a + 2 * b + c
        steep[channels + i] = c - a
    for padded in (smooth, steep):
        for k in range(channels):
            padded[k] = padded[channels + k]
            padded[channels + size + k] = padded[size + k]


@kernel
def _across(
    smooth_left: Float64,
    smooth_right: Float64,
    steep_left: Float64,
    steep: Float64,
    steep_right: Float64,
    gx: Float64,
    gy: Float64,
) -> None:
    for i in range(gx.size):
        gx[i] = (smooth_right[i] - smooth_left[i]) / 8
    for i in range(gy.size):
        gy[i] = (steep_left[i] + 2 * steep[i] + steep_right[i]) / 8


@kernel
def _tangents(gx: Float64, gy: Float64, tangent: Array, magnitude: Array) -> None:
    for x in range(magnitude.size):
        size = np.sqrt(gx[x] * gx[x] + gy[x] * gy[x])
        m = np.float32(min(size, _LARGEST))
        inverse = 1 / (size if m > 0 else np.inf)
        magnitude[x] = m
        tangent[x, 0] = -gy[x] * inverse
        tangent[x, 1] = gx[x] * inverse


@kernel
def _tangents_together(gx: Float64, gy: Float64, channels: int, tangent: Array, magnitude: Array) -> None:
    """Major eigenvector of sum_k g_k g_k^T, turned by 90 degrees."""
    for x in range(magnitude.size):
        c, s, trace = 0.0, 0.0, 0.0
        for i in range(x * channels, (x + 1) * channels):
            xx, yy = gx[i] * gx[i], gy[i] * gy[i]
            c, s, trace = c + (xx - yy), s + 2 * (gx[i] * gy[i]), trace + (xx + yy)
        magnitude[x] = min(np.sqrt((trace + np.sqrt(c * c + s * s)) / 2), _LARGEST)
        across_x, across_y = half_angle(c, s)
        there = 1.0 if magnitude[x] > 0 else 0.0
        tangent[x, 0] = -across_y * there
        tangent[x, 1] = across_x * there


@kernel
def half_angle(c: float, s: float) -> tuple[float, float]:
    """The unit vector at half the angle of (c, s), so the major eigenvector of [[c, s], [s, -c]]; zero for zero."""
    r = np.sqrt(c * c + s * s)
    large = np.sqrt((r + abs(c)) / 2)
    inverse = 0.0 if r == 0 else 1 / large
    small = s / 2 * inverse
    norm = 0.0 if r == 0 else 1 / np.sqrt(r)
    x = large if c >= 0 else small
    y = small if c >= 0 else large
    return x * norm, y * norm
