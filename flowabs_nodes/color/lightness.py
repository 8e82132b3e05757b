"""Luminance Y and CIE lightness L*, on arrays."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flowabs_nodes.color.constants import LAB_EPSILON, LAB_KAPPA
from flowabs_nodes.color.spaces import ColorSpace, normalised, space

Array = npt.NDArray[np.float32]


def luminance(rgb: npt.ArrayLike, colorspace: ColorSpace | str = "lin_rec709") -> Array:
    """(H, W, 3) scene-linear RGB to (H, W) luminance; Y of white is 1."""
    weights = normalised(space(colorspace))[1].astype(np.float32)
    return np.asarray(np.asarray(rgb, np.float32) @ weights, np.float32)


def lstar(luminance: npt.ArrayLike) -> Array:
    """L* 0..100 of Y 0..1, going on above white, linear below the toe."""
    y = np.asarray(luminance, np.float32)
    return np.asarray(np.where(y > LAB_EPSILON, 116 * np.cbrt(y) - 16, np.float32(LAB_KAPPA) * y), np.float32)


def lstar_inverse(lightness: npt.ArrayLike) -> Array:
    """Y of L*."""
    ls = np.asarray(lightness, np.float32)
    return np.asarray(np.where(ls > 8, ((ls + 16) / 116) ** 3, ls / np.float32(LAB_KAPPA)), np.float32)
