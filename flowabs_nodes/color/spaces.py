"""Scene-linear RGB spaces: their names, their matrices to CIE XYZ and to AP1."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import numpy.typing as npt

from flowabs_nodes.color.constants import BRADFORD, RGB_TO_XYZ, Matrix
from flowabs_nodes.errors import ColorError, nearest

Float64 = npt.NDArray[np.float64]


@dataclass(frozen=True)
class ColorSpace:
    """A scene-linear RGB space: its OCIO name, and its matrix to CIE XYZ as nine numbers, row by row."""

    name: str
    to_xyz: Matrix

    def __str__(self) -> str:
        return self.name


#: name -> (colour-science's name, other names people and files use).
_KNOWN: dict[str, tuple[str, tuple[str, ...]]] = {
    "lin_rec709": ("ITU-R BT.709", ("lin_rec709_scene", "lin_srgb", "Linear Rec.709 (sRGB)", "linear")),
    "lin_ap1_scene": ("ACEScg", ("lin_ap1", "acescg", "ACEScg")),
    "lin_ap0_scene": ("ACES2065-1", ("lin_ap0", "aces", "ACES2065-1")),
    "lin_rec2020_scene": ("ITU-R BT.2020", ("lin_rec2020", "Linear Rec.2020")),
    "lin_p3d65_scene": ("P3-D65", ("lin_p3d65", "Linear P3-D65")),
    "lin_adobergb_scene": ("Adobe RGB (1998)", ("lin_adobergb", "Linear AdobeRGB")),
}

KNOWN: dict[str, ColorSpace] = {name: ColorSpace(name, RGB_TO_XYZ[source]) for name, (source, _) in _KNOWN.items()}
_ALIASES = {alias.lower(): name for name, (_, aliases) in _KNOWN.items() for alias in (name, *aliases)}


def space(value: ColorSpace | str) -> ColorSpace:
    """The scene-linear space of that name."""
    if isinstance(value, ColorSpace):
        return value
    found = _ALIASES.get(str(value).lower())
    if found is None:
        raise ColorError(f"{value!r} is not a scene-linear colour space that is known here", hint=nearest(value, KNOWN))
    return KNOWN[found]


@cache
def normalised(colorspace: ColorSpace) -> Float64:
    """RGB to XYZ over the white of the space: rows sum to 1."""
    matrix = np.array(colorspace.to_xyz).reshape(3, 3)
    return np.asarray(matrix / matrix.sum(axis=1, keepdims=True))


@cache
def to_ap1(colorspace: ColorSpace) -> Float64:
    """RGB to ACES AP1, adapted to its white by Bradford: rows sum to 1."""
    source = np.array(colorspace.to_xyz).reshape(3, 3)
    ap1 = np.array(RGB_TO_XYZ["ACEScg"]).reshape(3, 3)
    bradford = np.array(BRADFORD).reshape(3, 3)
    scale = (bradford @ ap1.sum(axis=1)) / (bradford @ source.sum(axis=1))
    return np.asarray(np.linalg.inv(ap1) @ np.linalg.inv(bradford) @ np.diag(scale) @ bradford @ source)
