"""Code values: scene-linear RGB in an encoding where diffuse white is 255, and back.

The paper's parameters only mean something on 0..255, so this is what filters see. Highlights go on above 255, negative
colours below 0: every finite HDR value has a place and comes back.
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
from flowabs_nodes.simd.finite import refuse_non_finite
from flowabs_nodes.simd.known_finite import mark_finite
from flowabs_nodes.simd.matrix3 import Rows, rows
from flowabs_nodes.simd.pixelwise import as_picture, as_run, empty_run, over_pixels

NOTHING = np.empty(0, np.float32)
BARE = -1.0  # no ground at all: colours that are not multiplied by their alpha


def encode(rgb: npt.ArrayLike, space: str = "lab", colorspace: ColorSpace | str = "lin_rec709") -> Array:
    """Scene-linear RGB to code values.

    Parameters
    ----------
    rgb
        (H, W, 3), any finite numbers; white is 1. Not premultiplied.
    space
        "lab": CIE L*a*b* x 2.55, of XYZ over the space's own white: L* 0..255, a* = b* = 0 on neutrals. The cube root
        goes on above white, the toe's line below zero; or "acescct": ACEScct of each AP1 channel x 255 / ACEScct(1),
        26 codes a stop, white adapted to AP1's by Bradford, the line going on below zero.
    colorspace
        What RGB is: a :class:`ColorSpace` or its name.

    Returns
    -------
    (H, W, 3) float32: L*, a*, b*, or the three AP1 channels.

    Notes
    -----
    What comes back is within 2e-5 of the largest channel. Exceptions: near black, "acescct" holds steps of 1e-9; where
    one of X, Y, Z is as negative as another is positive, "lab" holds 8e-6 m^(2/3) of the largest channel m.

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
    """Code values back to scene-linear RGB: the inverse of :func:`encode`, with the same parameters and errors.

    ``codes`` (H, W, 3); returns (H, W, 3) float32.
    """
    return Codes(_pixels("codes", codes), _checked(space)).decode(find_space(colorspace))


def encode_mono(rgb: npt.ArrayLike, space: str = "lab", colorspace: ColorSpace | str = "lin_rec709") -> Array:
    """Scene-linear RGB to the code value of its lightness, with the parameters and errors of :func:`encode`.

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
    """Code values of a picture and of its lightness, made in one go; what is not asked for has no pixels.

    ``pixels`` (H, W, 3), or premultiplied (H, W, 4): then of rgb + (1 - A) ``ground``, with the ground ``BARE`` of
    rgb / A.
    """
    height, width, channels = pixels.shape
    run = as_run(pixels, channels)
    count = run.size // channels
    colors, lightness = empty_run(count, 3) if codes else NOTHING, empty_run(count) if mono else NOTHING
    forward, _, to_luminance = matrices(space, colorspace)
    if space == "lab":
        bad = over_pixels(lab.encode, count, run, channels, float(ground), forward, colors, lightness)
    else:
        bad = over_pixels(acescct.encode, count, run, channels, float(ground), forward, to_luminance, colors, lightness)
    if any(bad):
        refuse_non_finite("rgb", pixels)
        raise ArgumentError("rgb: divided by alpha, there are pixels beyond float32", parameter="rgb")
    return (
        mark_finite(as_picture(colors, *((height, width) if codes else (0, 0)), 3)),
        mark_finite(as_picture(lightness, *((height, width) if mono else (0, 0)))),
    )


@dataclass(frozen=True)
class Codes:
    """Code values that a picture can be made of: ``values`` (H, W, 3) in the encoding ``space``.

    ``under``, premultiplied (H, W, 4), is the picture that they are the colours of, if that one has alpha.
    """

    values: Array
    space: str
    under: Array | None = None

    @property
    def codes(self) -> Codes:
        """These; of a picture with more to be done, those that it begins with."""
        return self

    def decode(self, colorspace: ColorSpace) -> Array:
        """Return the scene-linear picture (H, W, 3), or premultiplied (H, W, 4) over one that has alpha.

        Alpha is that of the picture ``under``; where it is 0, what was there stays.
        """
        height, width, _ = self.values.shape
        channels = 3 if self.under is None else 4
        run, below = as_run(self.values, 3), NOTHING if self.under is None else as_run(self.under, 4)
        count = run.size // 3
        pixels = empty_run(count, channels)
        decode = lab.decode if self.space == "lab" else acescct.decode
        if any(over_pixels(decode, count, run, matrices(self.space, colorspace).backward, below, pixels)):
            refuse_non_finite("codes", self.values)
        return mark_finite(as_picture(pixels, height, width, channels))


class Matrices(NamedTuple):
    """Of a colour space and an encoding: RGB to the encoding's primaries, back, and to XYZ by way of AP1."""

    forward: Rows
    backward: Rows
    to_luminance: Rows  # over the white; its second row is the AP1 luminance


@cache
def matrices(space: str, colorspace: ColorSpace) -> Matrices:
    """Return the matrices of an encoding of a colour space."""
    matrix = normalised(colorspace) if space == "lab" else to_ap1(colorspace)
    return Matrices(
        rows(matrix),
        rows(np.asarray(np.linalg.inv(matrix), np.float64)),
        rows(normalised(KNOWN["lin_ap1_scene"]) @ to_ap1(colorspace)),
    )


def _checked(space: str) -> str:
    if space not in SPACES:
        raise ArgumentError(
            f"space: expected one of {', '.join(map(repr, SPACES))}, found {space!r}",
            hint=nearest(space, SPACES),
            parameter="space",
        )
    return space


def _pixels(name: str, value: npt.ArrayLike) -> Array:
    array = np.asarray(value)
    if array.dtype.kind not in "fiub":
        message = f"{name}: expected real numbers, found dtype {array.dtype}"
        raise ArgumentError(message, code="wrong-type", parameter=name)
    if array.ndim != 3 or array.shape[2] != 3 or array.size == 0:
        message = f"{name}: expected shape (H, W, 3) with at least one pixel, found {array.shape}"
        raise ArgumentError(message, parameter=name)
    with np.errstate(over="ignore"):  # what is too large for float32 becomes Inf, and is counted
        return np.ascontiguousarray(array, np.float32)
