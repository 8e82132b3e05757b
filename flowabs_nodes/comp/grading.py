"""Grades and inverts premultiplied pictures, and keeps them premultiplied."""

from __future__ import annotations

import numpy as np
import OpenImageIO as oiio

from flowabs_nodes.array_types import Array, Float64
from flowabs_nodes.color.spaces import ColorSpace, normalised
from flowabs_nodes.comp.buffers import ALGO, buffer, done, finite, pixels_of, repeated
from flowabs_nodes.errors import ArgumentError, nearest
from flowabs_nodes.image import Image

#: An alpha up to this is too small to divide by, and counts as 0 (as in simd/premultiplied.py).
TINY = 1e-20


def graded(image: Image, exposure: float, gain: float, offset: float, gamma: float, saturation: float) -> Image:
    """Return a color image after a grade; alpha stays.

    Of c, the colour divided by alpha: y = (c gain 2^exposure + offset)^(1/gamma), negative numbers without the power;
    then Y + saturation (y - Y), with Y the luminance of y in the image's own colour space. The result is multiplied by
    alpha again. Where alpha is 0, or below, there is light alone, such as a glow: gain, exposure and saturation apply.

    Raises
    ------
    ArgumentError
        The result leaves float32, or a pixel of the image is not finite.
    """
    pixels = image.pixels
    rgb = buffer(pixels[..., :3])
    alpha = np.maximum(pixels[..., 3:], 0) if pixels.shape[2] == 4 else None
    factor = 2.0**exposure * gain
    if factor != 1:
        rgb = done(ALGO.mul, rgb, factor)
    if offset != 0:  # of c; premultiplied, alpha times as much
        lifted = offset if alpha is None else done(ALGO.mul, repeated(buffer(alpha), 0, 3), offset)
        rgb = done(ALGO.add, rgb, lifted)
    if gamma != 1:
        rgb = _bent(finite(pixels_of(rgb), "grade"), alpha, 1 / gamma)
    if saturation != 1:
        rgb = done(ALGO.colormatrixtransform, rgb, _saturating(saturation, image.colorspace), False)
    result = finite(pixels_of(rgb), "grade")
    return image.with_pixels(result if alpha is None else np.concatenate([result, pixels[..., 3:]], axis=2))


def _bent(rgb: Array, alpha: Array | None, power: float) -> oiio.ImageBuf:
    """Return rgb, premultiplied by alpha (H, W, 1), whose colours are raised to a power where they are above 0."""
    covered = rgb > 0 if alpha is None else (rgb > 0) & (alpha > TINY)
    weight = np.float32(1) if alpha is None else np.where(alpha > TINY, alpha, np.float32(1))
    with np.errstate(over="ignore"):  # told by the caller
        colours = pixels_of(done(ALGO.pow, buffer(np.where(covered, rgb / weight, 0)), power))
        return buffer(np.where(covered, colours * weight, rgb))


def _saturating(saturation: float, colorspace: ColorSpace) -> tuple[float, ...]:
    """Return the 4x4 matrix, for row vectors as OpenImageIO has them, that moves colours from or to their luminance."""
    matrix: Float64 = np.eye(4)
    weights = normalised(colorspace)[1]  # of R, G, B in Y: they sum to 1
    matrix[:3, :3] = saturation * np.eye(3) + (1 - saturation) * np.repeat(weights[:, None], 3, axis=1)
    return tuple(matrix.ravel().tolist())


def inverted(image: Image, channels: str) -> Image:
    """Return a color, mono or matte image with some channels inverted: 1 - x, of premultiplied colours alpha - x.

    ``channels`` are names with commas between; "" are all but alpha, "*" all. Alpha - x is the premultiplied form of
    1 - x / alpha: what is transparent stays black.

    Raises
    ------
    ArgumentError
        The image has no such channel.
    """
    names = image.channels
    wanted = tuple(name.strip() for name in channels.split(",")) if channels not in ("", "*") else names
    for name in wanted:
        if name not in names:
            raise ArgumentError(f"the image has no channel {name!r}", hint=nearest(name, names), parameter="channels")
    if channels == "":
        wanted = tuple(name for name in names if name != "A")
    pixels = image.pixels
    white = buffer(np.ones_like(pixels))
    if "A" in names:
        white = done(ALGO.channels, buffer(pixels), (3, 3, 3, 1.0), ("R", "G", "B", "A"))
    changed = pixels_of(done(ALGO.sub, white, buffer(pixels)))
    return image.with_pixels(np.where([name in wanted for name in names], changed, pixels))
