"""Encode scene-linear RGB as code values, an encoding in which diffuse white is 255, and decode it again.

Filters see code values, because the paper's parameters only mean something on 0..255. Highlights continue above 255 and
negative colours below 0: every finite HDR value has a code value and comes back.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.choices import SPACES
from flowabs_nodes.color import acescct, lab
from flowabs_nodes.color.lookup import space as find_space
from flowabs_nodes.color.spaces import KNOWN, ColorSpace, normalised, to_ap1
from flowabs_nodes.errors import ArgumentError, nearest
from flowabs_nodes.simd.finite import ROOM, refuse_overflow
from flowabs_nodes.simd.known_finite import mark_finite
from flowabs_nodes.simd.matrix3 import Rows, rows
from flowabs_nodes.simd.pixelwise import as_picture, as_run, empty_run, over_pixels
from flowabs_nodes.simd.premultiplied import TINY

NOTHING = np.empty(0, np.float32)  # the run of pixels of a picture that there is not
OPPONENT = "acescct, opponent"  # the encoding of :func:`encoded` whose channels are lightness, red and blue less it
BARE = -1.0  # the "ground" that stands for none: colours are divided by their alpha


def encode(rgb: npt.ArrayLike, space: str = "lab", colorspace: ColorSpace | str = "lin_rec709") -> Array:
    """Encode scene-linear RGB as code values.

    Parameters
    ----------
    rgb
        (H, W, 3), any finite numbers; white is 1. Not premultiplied.
    space
        "lab": CIE L*a*b* x 2.55, of XYZ over the space's own white: L* 0..255, a* = b* = 0 on neutrals. The cube root
        continues above white, the toe's line below zero. Or "acescct": ACEScct of each AP1 channel x 255 / ACEScct(1),
        26 codes a stop, white adapted to AP1's by Bradford, the line continuing below zero.
    colorspace
        The scene-linear space of ``rgb``: a :class:`ColorSpace` or its name.

    Returns
    -------
    (H, W, 3) float32: L*, a*, b*, or the three AP1 channels.

    Notes
    -----
    :func:`decode` returns colours to within 2e-5 of the largest channel. But near black, "acescct" holds steps of
    1e-9; where one of X, Y, Z is as negative as another is positive, "lab" holds 8e-6 m^(2/3) of the largest channel m.

    Raises
    ------
    ArgumentError
        For another shape, numbers that are not real or not finite, or an unknown ``space``.
    ColorError
        For a colour space that is not known.

    References
    ----------
    CIE 15:2004; Academy S-2016-001 (ACEScct). Constants are colour-science's.
    """
    codes, _ = encoded(_pixels("rgb", rgb), _checked(space), find_space(colorspace), mono=False)
    return codes


def decode(codes: npt.ArrayLike, space: str = "lab", colorspace: ColorSpace | str = "lin_rec709") -> Array:
    """Decode code values (H, W, 3) to scene-linear RGB (H, W, 3) float32: the inverse of :func:`encode`.

    The parameters and errors are those of :func:`encode`.
    """
    return Codes(_pixels("codes", codes), _checked(space)).decode(find_space(colorspace))


def encode_mono(rgb: npt.ArrayLike, space: str = "lab", colorspace: ColorSpace | str = "lin_rec709") -> Array:
    """Encode the lightness of scene-linear RGB, with the parameters and errors of :func:`encode`.

    Returns (H, W) float32: L* x 2.55, the same bits as ``encode(...)[..., 0]``; or ACEScct of the AP1 luminance (the
    second row of AP1's matrix to XYZ) x 255 / ACEScct(1).
    """
    _, mono = encoded(_pixels("rgb", rgb), _checked(space), find_space(colorspace), codes=False)
    return mono


def encoded(
    pixels: Array,
    space: str,
    colorspace: ColorSpace,
    *,
    ground: float = BARE,
    codes: bool = True,
    mono: bool = True,
) -> tuple[Array, Array]:
    """Return the code values (H, W, 3) of a picture and of its lightness (H, W), float32, from one pass.

    ``space`` is "lab", "acescct" or ``OPPONENT``: lightness in acescct, red less it, blue less it. ``pixels`` is (H, W,
    3), or premultiplied (H, W, 4): then rgb + (1 - A) ``ground`` is encoded, or rgb / A with the ground ``BARE``. With
    ``codes`` or ``mono`` False, the result not asked for has no pixels. ArgumentError for pixels that are not finite,
    or that are not once divided by alpha.
    """
    height, width, channels = pixels.shape
    run = as_run(pixels, channels)
    count = run.size // channels
    colors, lightness = empty_run(count, 3) if codes else NOTHING, empty_run(count) if mono else NOTHING
    forward, _, to_luminance = matrices(space, colorspace)
    if space == "lab":
        bad = over_pixels(lab.encode, count, run, channels, float(ground), forward, colors, lightness)
    else:
        matrix_pair, opponent = acescct.ToAp1(forward, to_luminance), space == OPPONENT
        bad = over_pixels(acescct.encode, count, run, channels, float(ground), matrix_pair, opponent, colors, lightness)
    colors = as_picture(colors, *((height, width) if codes else (0, 0)), 3)
    lightness = as_picture(lightness, *((height, width) if mono else (0, 0)))
    if any(bad):
        _refuse_to_encode(pixels, ground, colors if codes else lightness[..., None])
    return mark_finite(colors), mark_finite(lightness)


def _refuse_to_encode(pixels: Array, ground: float, codes: Array) -> None:
    """Raise an ArgumentError for pixels that are not finite over the ground, or whose code values are not, or enormous.

    ``ground`` is that of :func:`encoded`, ``codes`` what became of the pixels.
    """
    seen = pixels[..., :3]
    with np.errstate(all="ignore"):
        if pixels.shape[2] == 4:
            alpha = pixels[..., 3:]
            seen = np.where(alpha > TINY, seen / alpha, 0) if ground < 0 else seen + (1 - alpha) * np.float32(ground)
        refuse_overflow("rgb", pixels, seen)
        refuse_overflow("rgb", pixels, codes * np.float32(ROOM))


@dataclass(frozen=True)
class Codes:
    """Code values that a picture can be decoded from.

    Attributes
    ----------
    values
        (H, W, 3) float32.
    space
        Their encoding, "lab" or "acescct".
    under
        The picture whose colours they replace, premultiplied (H, W, 4), where this picture has alpha; else None.
    """

    values: Array
    space: str
    under: Array | None = None

    @property
    def shape(self) -> tuple[int, int, int]:
        """Return the shape of the picture, (H, W, 3), or (H, W, 4) where it has alpha."""
        height, width, _ = self.values.shape
        return height, width, 3 if self.under is None else 4

    @property
    def codes(self) -> Codes:
        """Return this object itself, as a ``PixelSource`` (image.py) that only has to be decoded."""
        return self

    def decode_rows(self, first: int, last: int, colorspace: ColorSpace) -> Array:
        """Return the rows ``first`` .. ``last`` - 1 of :meth:`decode`."""
        under = None if self.under is None else self.under[first:last]
        return Codes(self.values[first:last], self.space, under).decode(colorspace)

    def decode(self, colorspace: ColorSpace) -> Array:
        """Return the scene-linear picture (H, W, 3), or premultiplied (H, W, 4) with the alpha of ``under``.

        Where alpha is 0, the pixels of ``under`` stay. ArgumentError for code values that are not finite.
        """
        height, width, channels = self.shape
        run, below = as_run(self.values, 3), NOTHING if self.under is None else as_run(self.under, 4)
        count = run.size // 3
        pixels = empty_run(count, channels)
        decode = lab.decode if self.space == "lab" else acescct.decode
        if any(over_pixels(decode, count, run, matrices(self.space, colorspace).backward, below, pixels)):
            refuse_overflow("codes", self.values, as_picture(pixels, height, width, channels))
        return mark_finite(as_picture(pixels, height, width, channels))


class Matrices(NamedTuple):
    """The matrices that encode the RGB of a colour space."""

    forward: Rows  # to XYZ over the white ("lab"), or to AP1 ("acescct")
    backward: Rows  # the inverse
    to_luminance: Rows  # to XYZ over the white by way of AP1; the second row gives the AP1 luminance


@cache
def matrices(space: str, colorspace: ColorSpace) -> Matrices:
    """Return the matrices of a colour space and an encoding ``space``."""
    matrix = normalised(colorspace) if space == "lab" else to_ap1(colorspace)
    return Matrices(
        rows(matrix),
        rows(np.asarray(np.linalg.inv(matrix), np.float64)),
        rows(normalised(KNOWN["lin_ap1_scene"]) @ to_ap1(colorspace)),
    )


def _checked(space: str) -> str:
    """Return ``space``, or raise ArgumentError if it is no encoding."""
    if space not in SPACES:
        raise ArgumentError(
            f"space: expected one of {', '.join(map(repr, SPACES))}, found {space!r}",
            hint=nearest(space, SPACES),
            parameter="space",
        )
    return space


def _pixels(name: str, value: npt.ArrayLike) -> Array:
    """Return the argument ``name`` as (H, W, 3) float32, or raise ArgumentError; kernels check that it is finite."""
    array = np.asarray(value)
    if array.dtype.kind not in "fiub":
        message = f"{name}: expected real numbers, found dtype {array.dtype}"
        raise ArgumentError(message, code="wrong-type", parameter=name)
    if array.ndim != 3 or array.shape[2] != 3 or array.size == 0:
        message = f"{name}: expected shape (H, W, 3) with at least one pixel, found {array.shape}"
        raise ArgumentError(message, parameter=name)
    with np.errstate(over="ignore"):  # numbers too large for float32 become Inf, and are counted
        return np.ascontiguousarray(array, np.float32)
