"""Compute luminance Y and CIE lightness L* of arrays, in plain NumPy."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.color.constants import LAB_EPSILON, LAB_KAPPA
from flowabs_nodes.color.lookup import space
from flowabs_nodes.color.spaces import ColorSpace, normalised
from flowabs_nodes.errors import ArgumentError

_EPSILON, _KAPPA = np.float32(LAB_EPSILON), np.float32(LAB_KAPPA)


def luminance(rgb: npt.ArrayLike, colorspace: ColorSpace | str = "lin_rec709") -> Array:
    """Return the relative luminance of scene-linear RGB: Y of CIE XYZ, 1 for white, float32.

    ``rgb`` is (..., 3), usually (H, W, 3), and the result (...). The luminance of a neutral is exactly its value.
    Raises ArgumentError for another shape, ColorError for a colour space that is not known.
    """
    pixels = np.asarray(rgb, np.float32)
    if pixels.ndim == 0 or pixels.shape[-1] != 3:
        raise ArgumentError(f"rgb: expected shape (H, W, 3), found {pixels.shape}", parameter="rgb")
    red, _, blue = normalised(space(colorspace))[1].astype(np.float32)
    r, g, b = pixels[..., 0], pixels[..., 1], pixels[..., 2]
    return np.asarray(g + (red * (r - g) + blue * (b - g)), np.float32)  # the weights sum to 1: see simd/matrix3.py


def lstar(luminance: npt.ArrayLike) -> Array:
    """Return the CIE 1976 lightness L* of a luminance, 0..100 for 0..1, of the same shape, float32.

    The cube root continues above white, the toe's line below zero.
    """
    y = np.asarray(luminance, np.float32)
    return np.asarray(np.where(y > _EPSILON, 116 * np.cbrt(y) - 16, _KAPPA * y), np.float32)


def lstar_inverse(lightness: npt.ArrayLike) -> Array:
    """Return the luminance of a CIE 1976 lightness L*, of the same shape, float32: the inverse of :func:`lstar`."""
    lightness = np.asarray(lightness, np.float32)
    return np.asarray(np.where(lightness > 8, ((lightness + 16) / 116) ** 3, lightness / _KAPPA), np.float32)
