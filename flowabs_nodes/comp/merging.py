"""Merges two pictures by Nuke's formulas, premultiplied."""

from __future__ import annotations

import numpy as np
import OpenImageIO as oiio

from flowabs_nodes.array_types import Array
from flowabs_nodes.color.spaces import ColorSpace, convert
from flowabs_nodes.comp.buffers import ALGO, buffer, done, finite, pixels_of, repeated
from flowabs_nodes.image import Image
from flowabs_nodes.port_types import widest

#: The operations whose formula has an alpha in it, in which a matte stands for its own coverage.
BY_ALPHA = ("over", "under", "mask", "stencil")


def merged(a: Image, b: Image, operation: str) -> Image:
    """Return A and B merged by an operation of :data:`flowabs_nodes.choices.MERGE_OPERATIONS`.

    Both are color, mono or matte, on one data window. The result has B's windows and metadata, and the wider type of
    the two. Alpha goes by the same formula as the colours. A color image without alpha is opaque, and so is a mono; a
    matte is its own alpha where the formula has one, elsewhere, beside a color, a grey picture that is opaque. The
    result has alpha if A or B has one. A matte of two mattes is kept within 0 to 1. A color A is brought to the colour
    space of a color B.

    Raises
    ------
    ArgumentError
        The result leaves float32, or an input was not finite.
    """
    kind = widest((a.type, b.type))
    assert kind is not None, "all three types may be used as color"
    if kind != "color":
        alphas = [image.pixels if image.type == "matte" else np.ones_like(image.pixels) for image in (a, b)]
        pixels = _merged(a.pixels, b.pixels, alphas[0], alphas[1], operation)
        return b.with_pixels(np.clip(pixels, 0, 1) if kind == "matte" else pixels, kind)
    space = b.colorspace if b.type == "color" else a.colorspace
    covering = operation in BY_ALPHA and "matte" in (a.type, b.type)
    with_alpha = covering or "A" in a.channels or "A" in b.channels
    one, other = (_rgba(image, space, operation) for image in (a, b))
    pixels = _merged(one, other, one[..., 3:], other[..., 3:], operation)[..., : 3 + with_alpha]
    typed = b.with_pixels(pixels, "color")
    return Image(typed.pixels, typed.spec, "color", colorspace=space, origin=b.origin)


def _rgba(image: Image, space: ColorSpace, operation: str) -> Array:
    """Return any of the three types as premultiplied RGBA, (H, W, 4), in ``space``."""
    pixels = image.pixels
    result = np.ones((*pixels.shape[:2], 4), np.float32)
    if image.type == "color":
        result[..., : pixels.shape[2]] = pixels
        result[..., :3] = convert(pixels[..., :3], image.colorspace, space)
    else:
        result[..., : 4 if image.type == "matte" and operation in BY_ALPHA else 3] = pixels
    return result


def _merged(a: Array, b: Array, alpha_a: Array, alpha_b: Array, operation: str) -> Array:
    """Return the pixels (H, W, C) of A and B after an operation; the alphas are (H, W, 1)."""
    A, B = buffer(a), buffer(b)

    def coverage(alpha: Array) -> oiio.ImageBuf:
        """Return an alpha for every channel."""
        return repeated(buffer(alpha), 0, a.shape[2])

    def outside(alpha: Array) -> oiio.ImageBuf:
        """Return 1 - alpha for every channel."""
        return done(ALGO.invert, coverage(alpha))

    match operation:
        case "over":
            result = done(ALGO.mad, B, outside(alpha_a), A)
        case "under":
            result = done(ALGO.mad, A, outside(alpha_b), B)
        case "plus":
            result = done(ALGO.add, A, B)
        case "minus":
            result = done(ALGO.sub, A, B)
        case "multiply":
            result = done(ALGO.mul, A, B)
        case "screen":
            return _screened(a, b)
        case "min":
            result = done(ALGO.min, A, B)
        case "max":
            result = done(ALGO.max, A, B)
        case "difference":
            result = done(ALGO.absdiff, A, B)
        case "mask":
            result = done(ALGO.mul, B, coverage(alpha_a))
        case "stencil":
            result = done(ALGO.mul, B, outside(alpha_a))
        case _:
            raise AssertionError(f"{operation!r} is not in MERGE_OPERATIONS")
    return finite(pixels_of(result), operation)


def _screened(a: Array, b: Array) -> Array:
    """Return A + B - A B where both are 0 to 1, elsewhere the larger: screening by a light above 1 would darken."""
    # A + B (1 - A): one operation of OpenImageIO fewer, and 1 where A is 1.
    A, B = buffer(a), buffer(b)
    within = (a >= 0) & (a <= 1) & (b >= 0) & (b <= 1)
    screened = pixels_of(done(ALGO.mad, B, done(ALGO.invert, A), A))
    return finite(np.where(within, screened, pixels_of(done(ALGO.max, A, B))), "screen")
