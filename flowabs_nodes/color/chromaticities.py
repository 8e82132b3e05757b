"""A scene-linear space from the CIE xy of its primaries and white, as EXR files carry them."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

import numpy as np

from flowabs_nodes.color.constants import CHROMATICITIES, Matrix
from flowabs_nodes.color.spaces import KNOWN, SOURCES, ColorSpace
from flowabs_nodes.errors import ColorError

Pair = Sequence[float]

#: Primaries no further than this from those of a known space are that space's.
TOLERANCE = 1e-3


def space_from_chromaticities(r: Pair, g: Pair, b: Pair, w: Pair) -> ColorSpace:
    """The scene-linear space with these primaries and white, each a CIE (x, y).

    A known space where all are within 1e-3 of its own; else a new one, called "chromaticities(...)", whose matrix is
    the normalised primary matrix of SMPTE RP 177 (as ``colour.normalised_primary_matrix``). Imaginary primaries are
    fine.

    Raises
    ------
    ColorError
        If they span no colours: not finite, on one line, or a white outside of what has X, Y, Z > 0.
    """
    # Six decimals: what float32 holds of 0.3127, and what the name says is then exactly what the matrix is made of.
    values = tuple(round(float(value), 6) + 0.0 for value in (*r, *g, *b, *w))
    if len(values) != 8 or not all(math.isfinite(value) and abs(value) <= 1e3 for value in values):
        raise ColorError(f"chromaticities {values} are not four pairs of finite numbers", code="bad-chromaticities")
    for name, (source, _) in SOURCES.items():
        if all(abs(a - b) <= TOLERANCE for a, b in zip(values, CHROMATICITIES[source], strict=True)):
            return KNOWN[name]
    return ColorSpace(f"chromaticities({','.join(f'{value:.6g}' for value in values)})", _primary_matrix(values))


def parse(name: str) -> ColorSpace:
    """The space called "chromaticities(rx,ry,gx,gy,bx,by,wx,wy)"."""
    match = re.fullmatch(r"chromaticities\(([^()]*)\)", name)
    try:
        values = [float(word) for word in match[1].split(",")] if match else []
    except ValueError:
        values = []
    if len(values) != 8:
        raise ColorError(f"{name!r} is not a colour space: expected chromaticities(rx,ry,gx,gy,bx,by,wx,wy)")
    return space_from_chromaticities(values[0:2], values[2:4], values[4:6], values[6:8])


def chromaticities_of(colorspace: ColorSpace) -> tuple[float, ...] | None:
    """For a file's header: (rx, ry, gx, gy, bx, by, wx, wy); None for a space that only an OCIO config knows."""
    if colorspace.name in SOURCES:
        return CHROMATICITIES[SOURCES[colorspace.name][0]]
    if colorspace.name.startswith("chromaticities("):
        return tuple(float(word) for word in colorspace.name[len("chromaticities(") : -1].split(","))
    return None


def _primary_matrix(values: tuple[float, ...]) -> Matrix:
    """RGB to XYZ: the primaries' x, y, z, each scaled so that together they make the white, whose Y is 1."""
    x, y = np.array(values[0::2]), np.array(values[1::2])
    xyz = np.stack([x, y, 1 - x - y])
    primaries, white = xyz[:, :3], xyz[:, 3]
    problem = ColorError(f"the chromaticities {values} do not span a colour space", code="bad-chromaticities")
    if (white <= 1e-3).any() or abs(np.linalg.det(primaries)) < 1e-4:
        raise problem
    matrix = primaries * np.linalg.solve(primaries, white / white[1])
    if np.linalg.cond(matrix) > 1e4:  # a white on the edge of the triangle: one primary would count for nothing
        raise problem
    m = matrix.ravel().tolist()
    return (m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8])
