"""Make a scene-linear space of the CIE xy of its primaries and white, as EXR files carry them, and the reverse."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

import numpy as np

from flowabs_nodes.color.constants import CHROMATICITIES, Matrix
from flowabs_nodes.color.spaces import KNOWN, SOURCES, ColorSpace
from flowabs_nodes.errors import ColorError

Pair = Sequence[float]  # CIE x, y

#: Chromaticities whose x and y all differ by no more than this from a known space's are taken for that space.
TOLERANCE = 1e-3


def space_from_chromaticities(r: Pair, g: Pair, b: Pair, w: Pair) -> ColorSpace:
    """Return the scene-linear space with these primaries and white, each a CIE (x, y).

    The result is a known space where all chromaticities are within 1e-3 of that space's. Else it is a new one, called
    "chromaticities(...)", whose matrix is the normalised primary matrix of SMPTE RP 177 (as
    ``colour.normalised_primary_matrix``). Imaginary primaries are allowed.

    Raises
    ------
    ColorError
        If they span no colours: some are not finite, the primaries are on one line, or X, Y or Z of the white is not
        above 0.
    """
    # Six decimals: float32, which files hold, is no more exact, and the name then tells exactly what the matrix is of.
    values = tuple(round(float(value), 6) + 0.0 for value in (*r, *g, *b, *w))
    if len(values) != 8 or not all(math.isfinite(value) and abs(value) <= 1e3 for value in values):
        raise ColorError(f"chromaticities {values} are not four pairs of finite numbers", code="bad-chromaticities")
    for name, (source, _) in SOURCES.items():
        if all(abs(a - b) <= TOLERANCE for a, b in zip(values, CHROMATICITIES[source], strict=True)):
            return KNOWN[name]
    return ColorSpace(f"chromaticities({','.join(f'{value:.6g}' for value in values)})", _primary_matrix(values))


def parse(name: str) -> ColorSpace:
    """Return the space called "chromaticities(rx,ry,gx,gy,bx,by,wx,wy)"; raise ColorError for a malformed name."""
    match = re.fullmatch(r"chromaticities\(([^()]*)\)", name)
    try:
        values = [float(word) for word in match[1].split(",")] if match else []
    except ValueError:
        values = []
    if len(values) != 8:
        raise ColorError(f"{name!r} is not a colour space: expected chromaticities(rx,ry,gx,gy,bx,by,wx,wy)")
    return space_from_chromaticities(values[0:2], values[2:4], values[4:6], values[6:8])


def chromaticities_of(colorspace: ColorSpace) -> tuple[float, ...] | None:
    """Return (rx, ry, gx, gy, bx, by, wx, wy) for a file's header; None for a space that only an OCIO config knows."""
    if colorspace.name in SOURCES:
        return CHROMATICITIES[SOURCES[colorspace.name][0]]
    if colorspace.name.startswith("chromaticities("):
        return tuple(float(word) for word in colorspace.name[len("chromaticities(") : -1].split(","))
    return None


def chromaticities_by_matrix(colorspace: ColorSpace) -> tuple[float, ...] | None:
    """Return what :func:`chromaticities_of` returns, from the matrix of any space; None where they are not the space.

    They are those after the white was adapted, if a config adapted it: the same colours by other numbers.
    """
    matrix = np.array(colorspace.to_xyz).reshape(3, 3)
    columns = np.column_stack([matrix, matrix.sum(axis=1)])
    with np.errstate(all="ignore"):
        pairs = (columns[:2] / columns.sum(axis=0)).T
    try:
        same = space_from_chromaticities(*pairs.tolist())
    except ColorError:
        return None
    return tuple(pairs.ravel().tolist()) if np.allclose(same.to_xyz, colorspace.to_xyz, atol=1e-3) else None


def _primary_matrix(values: tuple[float, ...]) -> Matrix:
    """Return the matrix from RGB to XYZ: the primaries' x, y, z as columns, scaled to sum to the white of Y = 1."""
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
