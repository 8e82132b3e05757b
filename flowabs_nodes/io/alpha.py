"""Convert straight colour to premultiplied, and back."""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array


def premultiplied(rgb: Array, alpha: Array) -> Array:
    """Return (H, W, 3) straight colour times its (H, W) alpha."""
    with np.errstate(over="ignore"):
        return np.asarray(rgb * alpha[..., None], np.float32)


def straight(rgb: Array, alpha: Array) -> Array:
    """Return (H, W, 3) premultiplied colour over its (H, W) alpha; colour stays as it is where alpha is 0 or less."""
    a = alpha[..., None]
    with np.errstate(over="ignore"):
        return np.divide(rgb, a, out=rgb.copy(), where=a > 0)
