"""Convert pixels from and to encodings: by their OCIO names (display sRGB, camera logs ...), or a file's own."""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.color import cineon, config, srgb
from flowabs_nodes.color.encoding import Encoding
from flowabs_nodes.color.named import find
from flowabs_nodes.color.spaces import KNOWN, ColorSpace, convert
from flowabs_nodes.errors import ArgumentError


def linearize(pixels: Array, name: str | Encoding, ocio: str | None = None) -> tuple[Array, ColorSpace]:
    """Decode pixels of an encoding to scene-linear.

    Parameters
    ----------
    pixels
        (H, W, 3 or 4) float32, not premultiplied; alpha stays as it is.
    name
        The encoding of the pixels: an OCIO name, alias or role, or what a file's profile says; "cineon" is known in
        every config.
    ocio
        An OCIO config (a path, or "ocio://..."); None is the pinned one.

    Returns
    -------
    The pixels, of the same shape, and their scene-linear space: the known space with the encoding's own primaries (sRGB
    and Cineon become linear Rec.709, ACEScct becomes AP1), else ACES2065-1. Pixels of a linear space stay as they are;
    "raw" counts as linear Rec.709.

    Raises
    ------
    ColorError
        If there is no such name, or the config cannot be read.
    """
    rgb, alpha = _split(pixels)
    if isinstance(name, Encoding):
        return _joined(name.linear(rgb), alpha), name.space
    found = find(name, ocio)
    if found.kind == "srgb":
        rgb = srgb.linear(rgb)
    elif found.kind == "cineon":
        rgb = cineon.linear(rgb)
    elif found.kind == "encoded":
        theirs, ours = config.reference(ocio)
        rgb = convert(config.convert(rgb, found.name, theirs, ocio), KNOWN[ours], found.space)
    return _joined(rgb, alpha), found.space


def encode_named(rgb: Array, colorspace: ColorSpace, name: str | Encoding, ocio: str | None = None) -> Array:
    """Encode scene-linear pixels of ``colorspace`` as the encoding ``name``: the inverse of :func:`linearize`.

    ``rgb`` is (H, W, 3 or 4) float32, not premultiplied, and the result has the same shape. A linear name only changes
    primaries, white to white by Bradford; "raw" changes nothing. Nothing is clamped. Raises ColorError as
    :func:`linearize` does.
    """
    linear, alpha = _split(rgb)
    if isinstance(name, Encoding):
        return _joined(name.encoded(convert(linear, colorspace, name.space)), alpha)
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
    """Return colour (H, W, 3) and alpha (H, W, 1) or None; raise ArgumentError for another shape."""
    pixels = np.asarray(pixels, np.float32)
    if pixels.ndim != 3 or pixels.shape[2] not in (3, 4):
        raise ArgumentError(f"pixels: expected shape (H, W, 3) or (H, W, 4), found {pixels.shape}", parameter="pixels")
    return pixels[..., :3], pixels[..., 3:] if pixels.shape[2] == 4 else None


def _joined(rgb: Array, alpha: Array | None) -> Array:
    """Return colour and alpha, if there is one, as one array: the inverse of :func:`_split`."""
    return np.ascontiguousarray(rgb if alpha is None else np.concatenate([rgb, alpha], axis=2))
