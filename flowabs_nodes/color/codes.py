"""Code values: scene-linear RGB in an encoding where diffuse white is 255, and back.

The paper's parameters only mean something on 0..255, so this is what filters see. Highlights go on above 255, negative
colours below 0: every finite HDR value has a place and comes back.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt

from flowabs_nodes.choices import SPACES
from flowabs_nodes.color import acescct, lab
from flowabs_nodes.color.spaces import KNOWN, ColorSpace, normalised, to_ap1
from flowabs_nodes.color.spaces import space as find_space
from flowabs_nodes.errors import ArgumentError, nearest
from flowabs_nodes.filters.validate import refuse
from flowabs_nodes.finishing.deferred import Undecoded
from flowabs_nodes.simd.known_finite import vouch
from flowabs_nodes.simd.matrix3 import Rows, rows
from flowabs_nodes.simd.pixelwise import new_run, over_pixels, picture_of, run_of

Array = npt.NDArray[np.float32]

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
    return decoded(Undecoded(_pixels("codes", codes), _checked(space)), find_space(colorspace))


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
    run = run_of(pixels, channels)
    count = run.size // channels
    colors, lightness = new_run(count, 3) if codes else NOTHING, new_run(count) if mono else NOTHING
    forward, _, to_luminance = _matrices(space, colorspace)
    if space == "lab":
        bad = over_pixels(lab.encode, count, run, channels, float(ground), forward, colors, lightness)
    else:
        bad = over_pixels(acescct.encode, count, run, channels, float(ground), forward, to_luminance, colors, lightness)
    if any(bad):
        refuse("rgb", pixels)
        raise ArgumentError("rgb: divided by alpha, there are pixels beyond float32", parameter="rgb")
    return (
        vouch(picture_of(colors, *((height, width) if codes else (0, 0)), 3)),
        vouch(picture_of(lightness, *((height, width) if mono else (0, 0)))),
    )


def decoded(undecoded: Undecoded, colorspace: ColorSpace) -> Array:
    """Code values as a scene-linear picture, (H, W, 3), or premultiplied (H, W, 4) over one that has alpha.

    Alpha is that of the picture ``under``; where it is 0, what was there stays.
    """
    codes, space, under, levels, softness, lines, ink = undecoded
    height, width, _ = codes.shape
    channels = 3 if under is None else 4
    run, below = run_of(codes, 3), NOTHING if under is None else run_of(under, 4)
    drawing = NOTHING if lines is None else run_of(lines)
    count = run.size // 3
    pixels = new_run(count, channels)
    backward = _matrices(space, colorspace)[1]
    if space == "lab":
        bad = over_pixels(lab.decode, count, run, backward, (levels / 100, softness), below, drawing, ink, pixels)
    else:
        bad = over_pixels(acescct.decode, count, run, backward, below, drawing, ink, pixels)
    if any(bad):
        refuse("codes", codes)
    return vouch(picture_of(pixels, height, width, channels))


def flattened(pixels: Array, levels: int, softness: float, colorspace: ColorSpace) -> Array:
    """A scene-linear picture, (H, W, 3) or premultiplied (H, W, 4), with L* quantised by a gain."""
    channels = pixels.shape[2]
    run = run_of(pixels, channels)
    flat = new_run(run.size // channels, channels)
    forward = _matrices("lab", colorspace)[0]
    if any(over_pixels(lab.flatten, run.size // channels, run, channels, forward, (levels / 100, softness), flat)):
        refuse("rgb", pixels)
    return vouch(picture_of(flat, *pixels.shape))


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
