"""Draws an image of any type as a small PNG, for notebooks."""

from __future__ import annotations

import struct
import zlib
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes.array_types import Array
from flowabs_nodes.color.spaces import KNOWN, ColorSpace, convert
from flowabs_nodes.port_types import pixel_type

if TYPE_CHECKING:
    from flowabs_nodes.image import Image

#: The longer side of a preview, in pixels, at most.
LARGEST = 1024
#: Light beyond counts as this, so that sums and differences stay finite.
_MOST = 1e30


def png(image: Image) -> bytes:
    """Return a PNG of an image, its longer side at most :data:`LARGEST`.

    Colour is what a written PNG shows: sRGB, light above 1 clipped, alpha kept; NaN counts as 0. Any other type is
    looked at as ``--view`` does (:attr:`flowabs_nodes.port_types.PixelType.look`).
    """
    if image.type == "color":
        light = np.nan_to_num(image.pixels, nan=0.0, posinf=_MOST, neginf=-_MOST).clip(-_MOST, _MOST)
        codes = _screen(_smaller(light), image.colorspace)
    else:
        codes = _smaller(pixel_type(image.type).look_function()(image).codes)
    return _encoded(np.rint(codes.clip(0, 1) * 255).astype(np.uint8))


def _smaller(pixels: Array) -> Array:
    """Return pixels (H, W, C), if need be the means of a smaller picture."""
    height, width, channels = pixels.shape
    factor = LARGEST / max(height, width)
    if factor >= 1:
        return pixels
    rows, columns = max(1, round(height * factor)), max(1, round(width * factor))
    buf = oiio.ImageBuf(np.ascontiguousarray(pixels))
    resized = oiio.ImageBufAlgo.resize(buf, filtername="box", roi=oiio.ROI(0, columns, 0, rows, 0, 1, 0, channels))
    return np.asarray(resized.get_pixels(oiio.FLOAT)).reshape(rows, columns, channels)


def _screen(pixels: Array, colorspace: ColorSpace) -> Array:
    """Return premultiplied scene-linear RGB or RGBA as sRGB, alpha straight."""
    from flowabs_nodes.color import srgb  # numba

    rgb, alpha = pixels[..., :3], pixels[..., 3:].clip(0, 1)
    if alpha.size:
        rgb = np.divide(rgb, alpha, out=np.zeros_like(rgb), where=alpha > 0)
    rgb = srgb.encoded(convert(np.ascontiguousarray(rgb), colorspace, KNOWN["lin_rec709"]).clip(0, 1))
    return np.concatenate([rgb, alpha], axis=2)


def _encoded(pixels: npt.NDArray[np.uint8]) -> bytes:
    """Return the PNG file of 8-bit pixels (H, W, 3 or 4): RGB or RGBA."""
    height, width, channels = pixels.shape
    kind = {3: 2, 4: 6}[channels]  # PNG's colour types
    rows = np.concatenate([np.zeros((height, 1), np.uint8), pixels.reshape(height, -1)], axis=1)  # 0: no row filter
    header = struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"sRGB", b"\0"), (b"IDAT", zlib.compress(rows.tobytes(), 6)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data)) for name, data in chunks
    )
