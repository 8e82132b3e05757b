"""Code values: scene-linear RGB in an encoding where diffuse white is 255, and back.

The paper's parameters only mean something on 0..255, so this is what filters see. Highlights go on above 255, negative
colours below 0: every finite HDR value has a place and comes back.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt

from flowabs_nodes.color import SPACES, acescct, lab
from flowabs_nodes.color.matrix import Rows, rows
from flowabs_nodes.color.spaces import KNOWN, ColorSpace, normalised, to_ap1
from flowabs_nodes.color.spaces import space as find_space
from flowabs_nodes.errors import ArgumentError, nearest

Array = npt.NDArray[np.float32]


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
    to_space = _matrices(_checked(space), find_space(colorspace))[0]
    source = _pixels("rgb", rgb)
    codes = np.empty_like(source)
    kernel = lab.encode if space == "lab" else acescct.encode
    _finite("rgb", source, kernel(_flat(source), to_space, _flat(codes)))
    return codes


def decode(codes: npt.ArrayLike, space: str = "lab", colorspace: ColorSpace | str = "lin_rec709") -> Array:
    """Code values back to scene-linear RGB: the inverse of :func:`encode`, with the same parameters and errors.

    ``codes`` (H, W, 3); returns (H, W, 3) float32.
    """
    from_space = _matrices(_checked(space), find_space(colorspace))[1]
    source = _pixels("codes", codes)
    rgb = np.empty_like(source)
    kernel = lab.decode if space == "lab" else acescct.decode
    _finite("codes", source, kernel(_flat(source), from_space, _flat(rgb)))
    return rgb


def encode_mono(rgb: npt.ArrayLike, space: str = "lab", colorspace: ColorSpace | str = "lin_rec709") -> Array:
    """Scene-linear RGB to the code value of its lightness, with the parameters and errors of :func:`encode`.

    Returns (H, W) float32: L* x 2.55, the same bits as ``encode(...)[..., 0]``; or ACEScct of the AP1 luminance (the
    second row of AP1's matrix to XYZ) x 255 / ACEScct(1).
    """
    forward, _, to_luminance = _matrices(_checked(space), find_space(colorspace))
    source = _pixels("rgb", rgb)
    mono = np.empty(source.shape[:2], np.float32)
    if space == "lab":
        bad = lab.encode_mono(_flat(source), forward, mono)
    else:
        bad = acescct.encode_mono(_flat(source), to_luminance, mono)
    _finite("rgb", source, bad)
    return mono


@cache
def _matrices(space: str, colorspace: ColorSpace) -> tuple[Rows, Rows, Rows]:
    """To the space's primaries, back, and to XYZ over the white by way of AP1 (its second row is the AP1 luminance)."""
    matrix = normalised(colorspace) if space == "lab" else to_ap1(colorspace)
    return (
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


def _flat(pixels: Array) -> Array:
    """(H, W, 3) as (H, 3 W), without a copy."""
    return pixels.reshape(pixels.shape[0], -1)


def _finite(name: str, source: Array, bad: int) -> None:
    if bad:
        count = int(source.size - np.isfinite(source).sum())
        raise ArgumentError(f"{name}: expected finite pixels, found {count} that are NaN or Inf", parameter=name)
