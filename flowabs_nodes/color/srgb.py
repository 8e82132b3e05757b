"""Encode and decode with the exact sRGB curve (IEC 61966-2-1); OCIO's is 2.4e-5 off and makes white 1.00002."""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array

#: The linear light at which line and power meet, 0.0031308 as in colour-science, and its sRGB.
_LINEAR_BREAK = np.float32(0.0031308)
_CODE_BREAK = np.float32(0.0031308 * 12.92)


def linear(codes: Array) -> Array:
    """Decode sRGB (0..1, any shape, float32) to linear light; the power continues above 1, the line below 0."""
    base = np.maximum((codes + np.float32(0.055)) / np.float32(1.055), 0)
    return np.asarray(
        np.where(codes <= _CODE_BREAK, codes * np.float32(1 / 12.92), base ** np.float32(2.4)), np.float32
    )


def encoded(rgb: Array) -> Array:
    """Encode linear light (any shape, float32) as sRGB: the inverse of :func:`linear`."""
    power = np.maximum(rgb, 0) ** np.float32(1 / 2.4)
    above = power + np.float32(0.055) * (power - 1)  # 1.055 power - 0.055, and 1 of 1 exactly
    return np.asarray(np.where(rgb <= _LINEAR_BREAK, rgb * np.float32(12.92), above), np.float32)
