"""Pixels from and to colour spaces that are not linear, by their OCIO names: display sRGB, ACEScct, camera logs ..."""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.color import cineon, config, srgb
from flowabs_nodes.color.named import find
from flowabs_nodes.color.spaces import KNOWN, ColorSpace, convert
from flowabs_nodes.errors import ArgumentError


def linearize(pixels: Array, name: str, ocio: str | None = None) -> tuple[Array, ColorSpace]:
    """Encoded pixels to scene-linear.

    Parameters
    ----------
    pixels
        (H, W, 3 or 4) float32; alpha stays as it is, and colour is taken as not premultiplied.
    name
        What the pixels are encoded in: an OCIO name, alias or role; "cineon" is known in every config.
    ocio
        An OCIO config (a path, or "ocio://..."); None is the pinned one.

    Returns
    -------
    The pixels, and their scene-linear space: the known one with the encoding's own primaries (sRGB and Cineon to linear
    Rec.709, ACEScct to AP1), else ACES2065-1. A space that is linear already is left as it is; "raw" counts as linear
    Rec.709.

    Raises
    ------
    ColorError
        If there is no such name, or the config cannot be read.
    """
    rgb, alpha = _split(pixels)
    found = find(name, ocio)
    if found.kind == "srgb":
        rgb = srgb.linear(rgb)
    elif found.kind == "cineon":
        rgb = cineon.linear(rgb)
    elif found.kind == "encoded":
        theirs, ours = config.reference(ocio)
        rgb = convert(config.convert(rgb, found.name, theirs, ocio), KNOWN[ours], found.space)
    return _joined(rgb, alpha), found.space


def encode_named(rgb: Array, colorspace: ColorSpace, name: str, ocio: str | None = None) -> Array:
    """Scene-linear pixels of ``colorspace`` in the encoding ``name``: the inverse of :func:`linearize`.

    ``rgb`` (H, W, 3 or 4) float32, not premultiplied; returns the same shape. A linear name only changes primaries,
    white to white by Bradford; "raw" changes nothing. Nothing is clamped. Raises ColorError as :func:`linearize`.
    """
    linear, alpha = _split(rgb)
    found = find(name, ocio)
    if found.kind == "data":
        return _joined(linear, alpha)
    if found.kind == "encoded":
        theirs, ours = config.reference(ocio)
        encoded = config.convert(convert(linear, colorspace, KNOWN[ours]), theirs, found.name, ocio)
    else:
        encoded = convert(linear, colorspace, found.space)
        if found.kind == "srgb":
            encoded = srgb.encoded(encoded)
        elif found.kind == "cineon":
            encoded = cineon.encoded(encoded)
    return _joined(encoded, alpha)


def _split(pixels: Array) -> tuple[Array, Array | None]:
    pixels = np.asarray(pixels, np.float32)
    if pixels.ndim != 3 or pixels.shape[2] not in (3, 4):
        raise ArgumentError(f"pixels: expected shape (H, W, 3) or (H, W, 4), found {pixels.shape}", parameter="pixels")
    return pixels[..., :3], pixels[..., 3:] if pixels.shape[2] == 4 else None


def _joined(rgb: Array, alpha: Array | None) -> Array:
    return np.ascontiguousarray(rgb if alpha is None else np.concatenate([rgb, alpha], axis=2))
