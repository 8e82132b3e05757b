"""ACEScct (Academy S-2016-001) of each channel in AP1, in code values, x 255 / ACEScct(1): kernels.

Arrays are (H, 3 W) or (H, W) float32, each row one run of memory (numba then vectorises over pixels).
"""

from __future__ import annotations

import numba
import numpy as np

from flowabs_nodes.color import constants
from flowabs_nodes.color.elementary import exp2, log2
from flowabs_nodes.color.matrix import Rows, mix, not_finite

f32 = np.float32

UNIT = 255 / constants.ACESCCT_WHITE  # code values of ACEScct 1.0
X_BREAK = f32(constants.ACESCCT_X_BRK)
Y_BREAK = f32(constants.ACESCCT_Y_BRK * UNIT)
TOE_SLOPE = f32(constants.ACESCCT_A * UNIT)
TOE_OFFSET = f32(constants.ACESCCT_B * UNIT)
PER_STOP = f32(UNIT / constants.ACESCCT_SCALE)
WHITE = f32(255)


@numba.njit(error_model="numpy")
def _code(x: np.float32) -> np.float32:
    # (log2 x + 9.72) / 17.52 of the standard, counted from white: exact there, and as exact near it as float32 is.
    above = WHITE + PER_STOP * log2(x)
    return above if x > X_BREAK else TOE_OFFSET + TOE_SLOPE * x


@numba.njit(error_model="numpy")
def _linear(code: np.float32) -> np.float32:
    above = exp2((code - WHITE) * f32(1 / PER_STOP))
    return above if code > Y_BREAK else (code - TOE_OFFSET) * f32(1 / TOE_SLOPE)


@numba.njit(parallel=True, nogil=True, cache=True, error_model="numpy")
def encode(rgb: np.ndarray, to_ap1: Rows, codes: np.ndarray) -> int:
    """Scene-linear RGB to ACEScct. Returns how many pixels are not finite."""
    bad = 0
    for row in numba.prange(rgb.shape[0]):
        source, target = rgb[row], codes[row]
        bad_here = 0
        for pixel in range(source.size // 3):
            i = np.uintp(3) * np.uintp(pixel)
            r, g, b = source[i], source[i + np.uintp(1)], source[i + np.uintp(2)]
            bad_here += not_finite(r, g, b)
            r, g, b = mix(to_ap1, r, g, b)
            target[i], target[i + np.uintp(1)], target[i + np.uintp(2)] = _code(r), _code(g), _code(b)
        bad += bad_here
    return bad


@numba.njit(parallel=True, nogil=True, cache=True, error_model="numpy")
def decode(codes: np.ndarray, from_ap1: Rows, rgb: np.ndarray) -> int:
    """ACEScct to scene-linear RGB. Returns how many pixels are not finite."""
    bad = 0
    for row in numba.prange(codes.shape[0]):
        source, target = codes[row], rgb[row]
        bad_here = 0
        for pixel in range(source.size // 3):
            i = np.uintp(3) * np.uintp(pixel)
            r, g, b = source[i], source[i + np.uintp(1)], source[i + np.uintp(2)]
            bad_here += not_finite(r, g, b)
            r, g, b = mix(from_ap1, _linear(r), _linear(g), _linear(b))
            target[i], target[i + np.uintp(1)], target[i + np.uintp(2)] = r, g, b
        bad += bad_here
    return bad


@numba.njit(parallel=True, nogil=True, cache=True, error_model="numpy")
def encode_mono(rgb: np.ndarray, to_luminance: Rows, codes: np.ndarray) -> int:
    """Scene-linear RGB to ACEScct of its AP1 luminance, the second row of ``to_luminance``."""
    bad = 0
    for row in numba.prange(rgb.shape[0]):
        source, target = rgb[row], codes[row]
        bad_here = 0
        for pixel in range(target.size):
            i = np.uintp(3) * np.uintp(pixel)
            r, g, b = source[i], source[i + np.uintp(1)], source[i + np.uintp(2)]
            bad_here += not_finite(r, g, b)
            target[np.uintp(pixel)] = _code(mix(to_luminance, r, g, b)[1])
        bad += bad_here
    return bad
