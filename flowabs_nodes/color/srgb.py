"""The sRGB curve (IEC 61966-2-1), exactly: OCIO's own is 2.4e-5 off, so that white would come in as 1.00002."""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array

#: Where line and power meet, as colour-science has it: 0.0031308 of linear light.
_LINEAR_BREAK = np.float32(0.0031308)
_CODE_BREAK = np.float32(0.0031308 * 12.92)


def linear(codes: Array) -> Array:
    """sRGB, 0..1, to linear light; goes on above 1 with the power and below 0 with the line."""
    base = np.maximum((codes + np.float32(0.055)) / np.float32(1.055), 0)
    return np.asarray(
        np.where(codes <= _CODE_BREAK, codes * np.float32(1 / 12.92), base ** np.float32(2.4)), np.float32
    )


def encoded(rgb: Array) -> Array:
    """Linear light to sRGB: the inverse of :func:`linear`."""
    power = np.maximum(rgb, 0) ** np.float32(1 / 2.4)
    above = power + np.float32(0.055) * (power - 1)  # 1.055 power - 0.055, and 1 of 1 exactly
    return np.asarray(np.where(rgb <= _LINEAR_BREAK, rgb * np.float32(12.92), above), np.float32)
