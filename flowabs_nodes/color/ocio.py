"""Convert pixels from and to encodings: by their OCIO names (display sRGB, camera logs ...), or a file's own."""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.color import cineon, config, srgb
from flowabs_nodes.color.config import Ocio
from flowabs_nodes.color.encoding import Encoding
from flowabs_nodes.color.named import Named, find
from flowabs_nodes.color.spaces import KNOWN, ColorSpace, convert
from flowabs_nodes.errors import ArgumentError, ColorError


def linearize(pixels: Array, name: str | Encoding, ocio: Ocio = None) -> tuple[Array, ColorSpace]:
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
        If there is no such name, the config cannot be read, or finite pixels become NaN or Inf (code "non-finite").
    """
    codes, alpha = _split(pixels)
    if isinstance(name, Encoding):
        with np.errstate(all="ignore"):
            rgb, space = name.linear(codes), name.space
    else:
        found = find(name, ocio)
        space = found.space
        with np.errstate(all="ignore"):
            rgb = _linear(codes, found)
    _refuse_overflow(f"decoded from {str(name)!r}", codes, rgb, "its pixels are no codes of that space")
    return _joined(rgb, alpha), space


def _linear(codes: Array, found: Named) -> Array:
    """Decode (H, W, 3) pixels of a name to its scene-linear space."""
    match found.kind:
        case "srgb":
            return srgb.linear(codes)
        case "cineon":
            return cineon.linear(codes)
        case "encoded":
            rgb, ours = config.to_known(codes, found.name, found.config)
            return convert(rgb, KNOWN[ours], found.space)
        case _:
            return codes


def encode_named(rgb: Array, colorspace: ColorSpace, name: str | Encoding, ocio: Ocio = None) -> Array:
    """Encode scene-linear pixels of ``colorspace`` as the encoding ``name``: the inverse of :func:`linearize`.

    ``rgb`` is (H, W, 3 or 4) float32, not premultiplied, and the result has the same shape. A linear name only changes
    primaries, white to white by Bradford; "raw" changes nothing. Nothing is clamped. Raises ColorError as
    :func:`linearize` does.
    """
    linear, alpha = _split(rgb)
    with np.errstate(all="ignore"):
        if isinstance(name, Encoding):
            encoded = name.encoded(convert(linear, colorspace, name.space))
        else:
            encoded = _encoded(linear, colorspace, find(name, ocio))
    _refuse_overflow(f"encoded as {str(name)!r}", linear, encoded, "that space cannot hold them")
    return _joined(encoded, alpha)


def _encoded(linear: Array, colorspace: ColorSpace, found: Named) -> Array:
    """Encode (H, W, 3) scene-linear pixels of ``colorspace`` as a name's."""
    match found.kind:
        case "data":
            return linear
        case "encoded":
            ours = config.known_of(found.name, found.config)
            return config.from_known(convert(linear, colorspace, KNOWN[ours]), found.name, found.config)
        case "srgb":
            return srgb.encoded(convert(linear, colorspace, found.space))
        case "cineon":
            return cineon.encoded(convert(linear, colorspace, found.space))
        case _:
            return convert(linear, colorspace, found.space)


def _refuse_overflow(what: str, before: Array, after: Array, hint: str) -> None:
    """Raise ColorError where finite pixels (H, W, 3) became NaN or Inf: how many, and the first one's place and value.

    ``what`` says what was done to them.
    """
    with np.errstate(invalid="ignore"):  # Inf - Inf
        if after is before or np.isfinite(after.sum(dtype=np.float64)):
            return
    bad = (~np.isfinite(after) & np.isfinite(before)).any(axis=2)
    if not bad.any():
        return
    y, x = np.argwhere(bad)[0]
    first = " ".join(f"{number:.6g}" for number in before[y, x])
    count = int(bad.sum())
    raise ColorError(
        f"{what}, {count} {'pixel becomes' if count == 1 else 'pixels become'} NaN or Inf, "
        f"the first at x {x}, y {y}: {first}",
        code="non-finite",
        hint=hint,
    )


def _split(pixels: Array) -> tuple[Array, Array | None]:
    """Return colour (H, W, 3) and alpha (H, W, 1) or None; raise ArgumentError for another shape."""
    pixels = np.asarray(pixels, np.float32)
    if pixels.ndim != 3 or pixels.shape[2] not in (3, 4):
        raise ArgumentError(f"pixels: expected shape (H, W, 3) or (H, W, 4), found {pixels.shape}", parameter="pixels")
    return pixels[..., :3], pixels[..., 3:] if pixels.shape[2] == 4 else None


def _joined(rgb: Array, alpha: Array | None) -> Array:
    """Return colour and alpha, if there is one, as one array: the inverse of :func:`_split`."""
    return np.ascontiguousarray(rgb if alpha is None else np.concatenate([rgb, alpha], axis=2))
