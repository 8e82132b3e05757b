"""Scene-linear RGB spaces: their names, and their matrices to CIE XYZ, to AP1 and to each other."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from flowabs_nodes.array_types import Array, Float64
from flowabs_nodes.color.constants import BRADFORD, RGB_TO_XYZ, Matrix


@dataclass(frozen=True, repr=False)
class ColorSpace:
    """A scene-linear RGB space.

    Attributes
    ----------
    name
        The space's name in the pinned OCIO config or the Color Interop Forum's list, such as "lin_rec709";
        "chromaticities(...)" for primaries without such a name. :func:`flowabs_nodes.color.space` finds the space by
        this name.
    to_xyz
        The matrix from RGB to CIE XYZ (Y of white = 1) as nine numbers, row by row.
    """

    name: str
    to_xyz: Matrix

    def __str__(self) -> str:
        return self.name

    def __repr__(self) -> str:
        return f"ColorSpace({self.name!r})"

    @property
    def interop_id(self) -> str | None:
        """Return the Color Interop ID, for EXR's ``colorInteropID``; None for a space that has none."""
        return None if self.name not in KNOWN else "lin_rec709_scene" if self.name == "lin_rec709" else self.name


#: Our name of each known space -> (colour-science's name, other names that people and files use).
SOURCES: dict[str, tuple[str, tuple[str, ...]]] = {
    "lin_rec709": (
        "ITU-R BT.709",
        ("lin_rec709_scene", "lin_rec709_srgb", "lin_srgb", "Linear Rec.709 (sRGB)", "Linear Rec.709", "linear"),
    ),
    "lin_ap1_scene": ("ACEScg", ("lin_ap1", "ACEScg", "ACES - ACEScg")),
    "lin_ap0_scene": ("ACES2065-1", ("lin_ap0", "aces", "aces2065_1", "ACES2065-1", "ACES - ACES2065-1")),
    "lin_rec2020_scene": ("ITU-R BT.2020", ("lin_rec2020", "Linear Rec.2020")),
    "lin_p3d65_scene": ("P3-D65", ("lin_p3d65", "lin_displayp3", "Linear P3-D65", "Linear Display P3")),
    "lin_adobergb_scene": ("Adobe RGB (1998)", ("lin_adobergb", "Linear AdobeRGB")),
}

KNOWN: dict[str, ColorSpace] = {name: ColorSpace(name, RGB_TO_XYZ[source]) for name, (source, _) in SOURCES.items()}

#: Names of the Color Interop Forum, which mean the same in every config.
STANDARD = frozenset((*KNOWN, "lin_rec709_scene"))

_ALIASES = {alias.lower(): name for name, (_, aliases) in SOURCES.items() for alias in (name, *aliases)}


def known(name: str) -> str | None:
    """Return our name of the known space with this name or alias, in any case; None if there is none."""
    return _ALIASES.get(name.lower())


@cache
def normalised(colorspace: ColorSpace) -> Float64:
    """Return the matrix (3, 3) from RGB to XYZ over the space's white: rows sum to 1, so neutrals have X = Y = Z."""
    matrix = np.array(colorspace.to_xyz).reshape(3, 3)
    return np.asarray(matrix / matrix.sum(axis=1, keepdims=True))


@cache
def to_ap1(colorspace: ColorSpace) -> Float64:
    """Return the matrix (3, 3) from RGB to ACES AP1, white adapted to AP1's by Bradford: rows sum to 1.

    It is ``colour.matrix_RGB_to_RGB(..., "Bradford")`` but for the whites, which here are the row sums of the matrices
    themselves: neutrals then stay neutral beyond the digits of a published white point.
    """
    source = np.array(colorspace.to_xyz).reshape(3, 3)
    ap1 = np.array(RGB_TO_XYZ["ACEScg"]).reshape(3, 3)
    bradford = np.array(BRADFORD).reshape(3, 3)
    scale = (bradford @ ap1.sum(axis=1)) / (bradford @ source.sum(axis=1))
    matrix = np.linalg.solve(ap1, np.linalg.solve(bradford, scale[:, None] * bradford @ source))
    return np.asarray(matrix / matrix.sum(axis=1, keepdims=True))


def between(source: ColorSpace, target: ColorSpace) -> Float64:
    """Return the matrix (3, 3) from RGB of one space to RGB of another, white adapted by Bradford."""
    return np.asarray(np.linalg.solve(to_ap1(target), to_ap1(source)))


def convert(rgb: Array, source: ColorSpace, target: ColorSpace) -> Array:
    """Convert (..., 3) float32 from one scene-linear space to another; neutrals keep their value exactly."""
    if source == target:
        return rgb
    m = between(source, target).astype(np.float32)
    r, g, b = rgb[..., 0], rgb[..., 1], rgb[..., 2]
    result = np.empty_like(rgb)  # the rows sum to 1: see simd/matrix3.py
    result[..., 0] = r + (m[0, 1] * (g - r) + m[0, 2] * (b - r))
    result[..., 1] = g + (m[1, 0] * (r - g) + m[1, 2] * (b - g))
    result[..., 2] = b + (m[2, 0] * (r - b) + m[2, 1] * (g - b))
    return result
