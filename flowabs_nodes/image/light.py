"""Bring the numbers of a host's picture to those of an image, and back.

An image's are float32, scene-linear and premultiplied. What a host's mean is in
:class:`~flowabs_nodes.image.numbers.Numbers`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes import color
from flowabs_nodes.array_types import Array
from flowabs_nodes.color.encoding import Encoding
from flowabs_nodes.color.spaces import ColorSpace, convert
from flowabs_nodes.errors import ColorError
from flowabs_nodes.image.numbers import Numbers
from flowabs_nodes.simd.bands import limited, over_rows

_LEAST = 16  # rows that are worth a thread
_AT_ONCE = 2**14  # pixels that are converted at once: what is made of them on the way stays in the processor's cache


# ---------------------------------------------------------------------- a host's numbers to an image's


def decoded(codes: npt.NDArray[Any], numbers: Numbers) -> Array:
    """Return a host's picture (H, W, 1, 3 or 4) as an image's: float32, scene-linear, premultiplied.

    Colours are in ``numbers.kept``, in memory of their own. uint8 and uint16 are divided by 255 or 65535 where
    ``numbers`` say that they are scaled.
    ColorError where finite numbers become NaN or Inf.
    """
    white = _white(codes.dtype) if numbers.scaled else 1.0
    result = np.empty(codes.shape, np.float32)
    curve = _curve(codes, numbers)
    left = numbers if curve is None else replace(numbers, encoding=None)  # what the curve leaves to do
    colors = min(codes.shape[2], 3)

    def fill(first: int, last: int) -> None:
        """Decode some rows."""
        band = result[first:last]
        if white == 1:
            band[...] = codes[first:last]
        else:
            np.divide(codes[first:last], np.float32(white), out=band, dtype=np.float32)
        if curve is not None:
            band[..., :colors] = curve.take(codes[first:last, :, :colors], mode="clip")
        if not left.plain or left.space != left.kept:
            with limited(1):
                _decode(band, left)

    _fill(fill, codes.shape, numbers)
    return result


def _curve(codes: npt.NDArray[Any], numbers: Numbers) -> Array | None:
    """Return the light of every uint8 or uint16 code, where each channel is looked up alone; None for all others."""
    premultiplied = codes.shape[2] == 4 and not numbers.straight
    if codes.dtype.kind == "f" or numbers.encoding is None or premultiplied or not _in_rows(numbers.encoding):
        return None
    white = int(_white(codes.dtype))
    every = np.arange(white + 1, dtype=codes.dtype).reshape(1, -1, 1) / np.float32(white)
    light, _ = color.ocio.linearize(np.repeat(every, 3, axis=2), numbers.encoding)
    return np.ascontiguousarray(light[0, :, 0])


def _decode(pixels: Array, numbers: Numbers) -> None:
    """Decode float32 codes (H, W, 1, 3 or 4) in place."""
    factor = None
    if pixels.shape[2] == 4 and not numbers.plain:
        factor = pixels[..., 3].copy() if numbers.straight else _divisor(pixels)
    if numbers.encoding is not None:
        if factor is not None and not numbers.straight:
            _each_color(np.divide, pixels, factor, pixels)
        codes = np.repeat(pixels, 3, axis=2) if pixels.shape[2] == 1 else pixels[..., :3]
        rgb, _ = color.ocio.linearize(codes, numbers.encoding)
        pixels[..., :3] = rgb[..., : pixels.shape[2]]
    if numbers.space != numbers.kept and pixels.shape[2] >= 3:
        pixels[..., :3] = convert(pixels[..., :3], numbers.space, numbers.kept)
    if factor is not None:
        _each_color(np.multiply, pixels, factor, pixels)


# ---------------------------------------------------------------------- an image's numbers to a host's


def encode_to(
    target: npt.NDArray[Any], picks: tuple[int | None, ...], pixels: Array, space: ColorSpace, numbers: Numbers
) -> None:
    """Write an image's pixels (H, W, 1, 3 or 4), scene-linear in ``space``, into a host's picture of any real dtype.

    ``picks`` are the image's channels for each of the target's, None for one that is 1 everywhere. Whole numbers are
    rounded, and clipped to 0..1 first, with NaN as 0. ColorError where finite pixels become NaN or Inf.
    """

    def fill(first: int, last: int) -> None:
        """Encode some rows."""
        band = pixels[first:last]
        if not numbers.plain or numbers.space != space:
            with limited(1):
                band = _encoded(band, space, numbers)
        write(target[first:last], picks, band)

    _fill(fill, pixels.shape, numbers)


def _encoded(pixels: Array, space: ColorSpace, numbers: Numbers) -> Array:
    """Return an image's pixels (H, W, 1, 3 or 4) as float32 codes of the same shape."""
    count, result, divisor = pixels.shape[2], pixels, None
    if count == 4 and not numbers.plain:
        result, divisor = np.empty_like(pixels), _divisor(pixels)
        result[..., 3] = pixels[..., 3]
        _each_color(np.divide, pixels, divisor, result)
    if numbers.encoding is not None:
        result = np.repeat(result, 3, axis=2) if count == 1 else result
        result = color.ocio.encode_named(result, space, numbers.encoding)[..., :count]
    elif numbers.space != space and count >= 3:
        result = result.copy() if result is pixels else result
        result[..., :3] = convert(result[..., :3], space, numbers.space)
    if divisor is not None and not numbers.straight:
        _each_color(np.multiply, result, divisor, result)
    return result


def write(target: npt.NDArray[Any], picks: tuple[int | None, ...], values: npt.NDArray[Any]) -> None:
    """Write values (H, W, C), white at 1, into a host's picture, in its data type."""
    if picks == tuple(range(values.shape[2])):
        target[...] = _in_type(values, target.dtype)
        return
    for index, pick in enumerate(picks):
        target[..., index] = _white(target.dtype) if pick is None else _in_type(values[..., pick], target.dtype)


def _in_type(values: npt.NDArray[Any], dtype: np.dtype[Any]) -> npt.NDArray[Any]:
    """Return values in a data type: whole numbers scaled, clipped and rounded, half floats at most 65504 or Inf."""
    if dtype.kind == "f":
        if dtype.itemsize > 2:
            return values
        with np.errstate(over="ignore"):
            half = values.astype(dtype)
        if np.isinf(half).any():
            most = np.float32(np.finfo(dtype).max)
            half = np.asarray(np.where(np.isinf(values), values, values.clip(-most, most)), dtype)
        return half
    scaled = np.fmin(np.fmax(values, np.float32(0)), np.float32(1))  # NaN becomes 0
    scaled *= np.float32(_white(dtype))
    return np.asarray(np.rint(scaled, out=scaled), dtype)


# ---------------------------------------------------------------------- alpha, rows


def _divisor(pixels: Array) -> Array:
    """Return what premultiplied colours (H, W, 4) are divided by, (H, W): alpha, and 1 where alpha is 0 or less."""
    return np.where(pixels[..., 3] > 0, pixels[..., 3], np.float32(1))


def _each_color(operation: np.ufunc, pixels: Array, factor: Array, result: Array) -> None:
    """Multiply or divide R, G, B of (H, W, 4) by a factor (H, W), to those of ``result``, which may be ``pixels``."""
    with np.errstate(all="ignore"):
        for channel in range(3):
            operation(pixels[..., channel], factor, out=result[..., channel])


def _white(dtype: np.dtype[Any]) -> float:
    """Return the number that stands for 1."""
    return 1.0 if dtype.kind == "f" else float(np.iinfo(dtype).max)


def _in_rows(encoding: str | Encoding | None) -> bool:
    """Return whether an encoding is a curve of ours, which bands of rows go through at once; not so OpenColorIO's."""
    if not isinstance(encoding, str):
        return encoding is None
    from flowabs_nodes.color import named

    return named.find(encoding).kind in ("srgb", "cineon")


def _fill(fill: Callable[[int, int], None], shape: tuple[int, ...], numbers: Numbers) -> None:
    """Call ``fill`` for all rows of a picture, some at a time, by all threads; once for all where OpenColorIO works.

    OpenColorIO shares the rows among threads itself.
    """
    height, at_once = shape[0], max(1, _AT_ONCE // shape[1])

    def fill_band(first: int, last: int) -> None:
        """Fill a thread's band of rows."""
        for start in range(first, last, at_once):
            fill(start, min(start + at_once, last))

    if not _in_rows(numbers.encoding):
        fill(0, height)
        return
    try:
        over_rows(fill_band, height, least=_LEAST)
    except ColorError:
        fill(0, height)  # its message tells the place in the picture
        raise
