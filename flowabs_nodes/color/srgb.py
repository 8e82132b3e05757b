"""Encode and decode with the exact sRGB curve (IEC 61966-2-1); OCIO's is 2.4e-5 off and makes white 1.00002."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.simd.bands import over_rows

#: The linear light at which line and power meet, 0.0031308 as in colour-science, and its sRGB.
_LINEAR_BREAK = np.float32(0.0031308)
_CODE_BREAK = np.float32(0.0031308 * 12.92)

_LEAST = 2**15  # values that are worth a thread
_MOST = 2**20


def linear(codes: Array) -> Array:
    """Decode sRGB (0..1, any shape, float32) to linear light; the power continues above 1, the line below 0."""
    return _in_bands(_linear, codes)


def encoded(rgb: Array) -> Array:
    """Encode linear light (any shape, float32) as sRGB: the inverse of :func:`linear`."""
    return _in_bands(_encoded, rgb)


def _linear(codes: Array) -> Array:
    base = np.maximum((codes + np.float32(0.055)) / np.float32(1.055), 0)
    return np.where(codes <= _CODE_BREAK, codes * np.float32(1 / 12.92), base ** np.float32(2.4))


def _encoded(rgb: Array) -> Array:
    power = np.maximum(rgb, 0) ** np.float32(1 / 2.4)
    above = power + np.float32(0.055) * (power - 1)  # 1.055 power - 0.055, and 1 of 1 exactly
    return np.where(rgb <= _LINEAR_BREAK, rgb * np.float32(12.92), above)


def _in_bands(curve: Callable[[Array], Array], values: Array) -> Array:
    """Return a curve of each value, float32; threads share the rows, and a band's own results stay in the cache."""
    result = np.empty(values.shape, np.float32)
    run, source = result.reshape(-1), values.reshape(-1)

    def fill(first: int, last: int) -> None:
        run[first:last] = curve(source[first:last])

    over_rows(fill, source.size, least=_LEAST, most=_MOST)
    return result
