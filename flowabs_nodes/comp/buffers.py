"""Calls OpenImageIO's ImageBufAlgo, and takes errors and numbers that leave float32 for what they are."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import OpenImageIO as oiio

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError, FlowabsError
from flowabs_nodes.image.convert import imagebuf_of

#: OpenImageIO's operations on whole pictures.
ALGO = oiio.ImageBufAlgo


def done(function: Callable[..., oiio.ImageBuf], *arguments: Any) -> oiio.ImageBuf:
    """Return what a function of ImageBufAlgo makes of its arguments; FlowabsError, code oiio-failed, if it fails."""
    result = function(*arguments)
    if result.has_error:
        name = getattr(function, "__name__", "ImageBufAlgo")
        raise FlowabsError(f"OpenImageIO's {name} failed: {result.geterror()}", code="oiio-failed")
    return result


def buffer(pixels: Array) -> oiio.ImageBuf:
    """Return an ImageBuf of pixels (H, W, C) float32 alone: without windows, names and metadata."""
    height, width, channels = pixels.shape
    return imagebuf_of(np.ascontiguousarray(pixels), oiio.ImageSpec(width, height, channels, oiio.FLOAT))


def pixels_of(buf: oiio.ImageBuf) -> Array:
    """Return the pixels of a buffer, (H, W, C) float32."""
    spec = buf.spec()
    return np.asarray(buf.get_pixels(oiio.FLOAT), np.float32).reshape(spec.height, spec.width, spec.nchannels)


def repeated(buf: oiio.ImageBuf, channel: int, times: int) -> oiio.ImageBuf:
    """Return a buffer that has one channel of another several times: an alpha, to weigh every channel by it."""
    return done(ALGO.channels, buf, (channel,) * times, tuple(f"channel{i}" for i in range(times)))


def finite(pixels: Array, what: str) -> Array:
    """Return the pixels of a result; ArgumentError where one is not finite, with ``what`` was done and its place."""
    bad = np.logical_not(np.isfinite(pixels).all(axis=2))
    if bad.any():
        y, x = np.argwhere(bad)[0]
        raise ArgumentError(
            f"{what} leaves float32 in {int(bad.sum())} pixels, first at row {y}, column {x} of the data window: "
            f"{pixels[y, x].tolist()}"
        )
    return pixels
