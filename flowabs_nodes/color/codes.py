"""Code values: scene-linear RGB to an encoding where diffuse white is 255, and back (DESIGN 4.1)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flowabs_nodes.color import constants as k
from flowabs_nodes.color.lightness import luminance
from flowabs_nodes.color.spaces import ColorSpace, normalised, to_ap1
from flowabs_nodes.color.spaces import space as _space

Array = npt.NDArray[np.float32]


def encode(rgb: npt.ArrayLike, space: str = "lab", colorspace: ColorSpace | str = "lin_rec709") -> Array:
    """(H, W, 3) scene-linear RGB to code values."""
    pixels = np.asarray(rgb, np.float64)
    if space == "acescct":
        return np.asarray(_cct(pixels @ to_ap1(_space(colorspace)).T), np.float32)
    f = _f(pixels @ normalised(_space(colorspace)).T)
    x, y, z = f[..., 0], f[..., 1], f[..., 2]
    return np.asarray(2.55 * np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], -1), np.float32)


def decode(codes: npt.ArrayLike, space: str = "lab", colorspace: ColorSpace | str = "lin_rec709") -> Array:
    """(H, W, 3) code values to scene-linear RGB."""
    c = np.asarray(codes, np.float64)
    if space == "acescct":
        v = c * (k.ACESCCT_WHITE / 255)
        ap1 = np.where(v > k.ACESCCT_Y_BRK, 2 ** (v * 17.52 - 9.72), (v - k.ACESCCT_B) / k.ACESCCT_A)
        return np.asarray(ap1 @ np.linalg.inv(to_ap1(_space(colorspace))).T, np.float32)
    c = c / 2.55
    y = (c[..., 0] + 16) / 116
    f = np.stack([y + c[..., 1] / 500, y, y - c[..., 2] / 200], -1)
    xyz = np.where(f > 6 / 29, f**3, (116 * f - 16) / k.LAB_KAPPA)
    return np.asarray(xyz @ np.linalg.inv(normalised(_space(colorspace))).T, np.float32)


def encode_mono(rgb: npt.ArrayLike, space: str = "lab", colorspace: ColorSpace | str = "lin_rec709") -> Array:
    """(H, W) code values of the lightness."""
    if space == "acescct":
        ap1 = np.asarray(rgb, np.float64) @ to_ap1(_space(colorspace)).T
        return np.asarray(_cct(ap1 @ normalised(_space("ACEScg"))[1]), np.float32)
    return np.asarray(2.55 * (116 * _f(luminance(rgb, colorspace).astype(np.float64)) - 16), np.float32)


def _f(x: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    return np.where(x > k.LAB_EPSILON, np.cbrt(x), (k.LAB_KAPPA * x + 16) / 116)


def _cct(x: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    log = (np.log2(np.maximum(x, k.ACESCCT_X_BRK)) + 9.72) / 17.52
    return np.where(x > k.ACESCCT_X_BRK, log, k.ACESCCT_A * x + k.ACESCCT_B) * (255 / k.ACESCCT_WHITE)
