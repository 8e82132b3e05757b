"""CIE 1976 L*a*b* (CIE 15:2004) in code values, x 2.55: kernels.

The kernels work with g = f - 16/116 instead of CIE's f: then L* = 116 g(Y), the toe is g = kappa/116 x without an
offset to cancel against, and black, tiny and negative values keep all their digits.

Arrays are (H, 3 W) or (H, W) float32, each row one run of memory (numba then vectorises over pixels).
"""

from __future__ import annotations

import numba
import numpy as np

from flowabs_nodes.color import constants
from flowabs_nodes.color.elementary import cube_root
from flowabs_nodes.color.matrix import Rows, mix, not_finite

f32 = np.float32

EPSILON = f32(constants.LAB_EPSILON)
SLOPE = f32(constants.LAB_KAPPA / 116)
OFFSET = f32(16 / 116)
G_EPSILON = f32(6 / 29 - 16 / 116)  # g(EPSILON)
L = f32(2.55 * 116)
A = f32(2.55 * 500)
B = f32(2.55 * 200)


@numba.njit(error_model="numpy")
def _g(x: np.float32) -> np.float32:
    above = cube_root(x) - OFFSET
    return above if x > EPSILON else SLOPE * x


@numba.njit(error_model="numpy")
def _g_inverse(g: np.float32) -> np.float32:
    f = g + OFFSET
    return f * f * f if g > G_EPSILON else g * f32(1 / SLOPE)


@numba.njit(parallel=True, nogil=True, cache=True, error_model="numpy")
def encode(rgb: np.ndarray, to_xyz: Rows, codes: np.ndarray) -> int:
    """Scene-linear RGB to L*, a*, b*; ``to_xyz`` is over the white. Returns how many pixels are not finite."""
    bad = 0
    for row in numba.prange(rgb.shape[0]):
        source, target = rgb[row], codes[row]
        bad_here = 0
        for pixel in range(source.size // 3):
            i = np.uintp(3) * np.uintp(pixel)
            r, g, b = source[i], source[i + np.uintp(1)], source[i + np.uintp(2)]
            bad_here += not_finite(r, g, b)
            x, y, z = mix(to_xyz, r, g, b)
            gx, gy, gz = _g(x), _g(y), _g(z)
            target[i] = L * gy
            target[i + np.uintp(1)] = A * (gx - gy)
            target[i + np.uintp(2)] = B * (gy - gz)
        bad += bad_here
    return bad


@numba.njit(parallel=True, nogil=True, cache=True, error_model="numpy")
def decode(codes: np.ndarray, from_xyz: Rows, rgb: np.ndarray) -> int:
    """L*, a*, b* to scene-linear RGB; ``from_xyz`` is over the white. Returns how many pixels are not finite."""
    bad = 0
    for row in numba.prange(codes.shape[0]):
        source, target = codes[row], rgb[row]
        bad_here = 0
        for pixel in range(source.size // 3):
            i = np.uintp(3) * np.uintp(pixel)
            lightness, a, b = source[i], source[i + np.uintp(1)], source[i + np.uintp(2)]
            bad_here += not_finite(lightness, a, b)
            gy = lightness * f32(1 / L)
            x, y, z = _g_inverse(gy + a * f32(1 / A)), _g_inverse(gy), _g_inverse(gy - b * f32(1 / B))
            target[i], target[i + np.uintp(1)], target[i + np.uintp(2)] = mix(from_xyz, x, y, z)
        bad += bad_here
    return bad


@numba.njit(parallel=True, nogil=True, cache=True, error_model="numpy")
def encode_mono(rgb: np.ndarray, to_xyz: Rows, codes: np.ndarray) -> int:
    """Scene-linear RGB to L* alone, the same bits as from :func:`encode`."""
    bad = 0
    for row in numba.prange(rgb.shape[0]):
        source, target = rgb[row], codes[row]
        bad_here = 0
        for pixel in range(target.size):
            i = np.uintp(3) * np.uintp(pixel)
            r, g, b = source[i], source[i + np.uintp(1)], source[i + np.uintp(2)]
            bad_here += not_finite(r, g, b)
            target[np.uintp(pixel)] = L * _g(mix(to_xyz, r, g, b)[1])
        bad += bad_here
    return bad
