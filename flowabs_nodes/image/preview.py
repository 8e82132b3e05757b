"""Draws an image of any type as a small PNG, for notebooks."""

from __future__ import annotations

import struct
import zlib
from typing import Any

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes.array_types import Array
from flowabs_nodes.color.spaces import KNOWN, ColorSpace, convert
from flowabs_nodes.port_types import PixelType

#: The longer side of a preview, in pixels, at most.
LARGEST = 1024
#: Values beyond count as this, so that sums and differences stay finite.
_MOST = 1e30

Bytes = npt.NDArray[np.uint8]


def png(pixels: npt.NDArray[Any], declared: PixelType, colorspace: ColorSpace) -> bytes:
    """Return a PNG of pixels (H, W, C) of a type, its longer side at most :data:`LARGEST`.

    Colour is shown as an sRGB screen does, light above 1 clipped, alpha kept. Mattes are grey, 0 black and 1 white;
    normals -1 to 1; a flow by its orientation (:func:`~flowabs_nodes.filters.flow_color`); ids in a colour each. Of all
    other types the first three channels are shown, each stretched from its least to its greatest value; what is
    infinitely far away counts as the farthest thing that is not. NaN counts as 0.
    """
    if declared.dtype.kind == "f":
        pixels = np.nan_to_num(pixels, nan=0.0, posinf=_MOST, neginf=-_MOST).clip(-_MOST, _MOST)
    pixels = _smaller(pixels, filtered=declared.filtered)
    shown: npt.NDArray[Any]
    match declared.name:
        case "color":
            shown = _screen(pixels, colorspace)
        case "matte":
            shown = pixels
        case "normal":
            shown = 0.5 + 0.5 * pixels
        case "flow":
            from flowabs_nodes.filters.flow.flow_color import flow_color  # numba, which other previews do not need

            shown = flow_color(pixels)
        case "id":
            shown = _colored(pixels)
        case _:
            far = declared.outside or np.inf
            shown = np.stack([_stretched(pixels[..., i], far) for i in range(min(pixels.shape[2], 3))], axis=2)
    return _encoded(np.rint(shown.clip(0, 1) * 255).astype(np.uint8))


def _smaller(pixels: npt.NDArray[Any], *, filtered: bool) -> npt.NDArray[Any]:
    """Return the pixels, if need be of a smaller picture: averaged, or each the nearest one."""
    height, width, channels = pixels.shape
    factor = LARGEST / max(height, width)
    if factor >= 1:
        return pixels
    rows, columns = max(1, round(height * factor)), max(1, round(width * factor))
    if not filtered:
        nearest: npt.NDArray[Any] = pixels[np.arange(rows) * height // rows][:, np.arange(columns) * width // columns]
        return nearest
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


def _colored(ids: npt.NDArray[np.uint32]) -> npt.NDArray[np.float64]:
    """Return a colour for each id (H, W, 1), mostly different ones for neighbours; black for the background, 0."""
    mixed = ids * np.uint32(2654435761)  # Knuth's multiplicative hash: the upper bits depend on all of the id's
    return np.concatenate([(mixed >> np.uint32(shift) & np.uint32(255)) / 255 for shift in (24, 16, 8)], axis=2)


def _stretched(values: npt.NDArray[Any], far: float) -> npt.NDArray[np.float64]:
    """Return values (H, W) from 0, the least, to 1, the greatest below ``far``, and beyond; equal ones 1/2."""
    values = values.astype(np.float64)
    near = values[values < far]
    if not near.size or near.min() == near.max():
        return np.where(values < far, 0.5, 1.0)
    return np.asarray((values - near.min()) / (near.max() - near.min()))


def _encoded(pixels: Bytes) -> bytes:
    """Return the PNG file of 8-bit pixels (H, W, 1 to 4): grey, grey and green without blue, RGB, or RGBA."""
    height, width, channels = pixels.shape
    if channels == 2:
        pixels = np.concatenate([pixels, np.zeros_like(pixels[..., :1])], axis=2)
    kind = {1: 0, 2: 2, 3: 2, 4: 6}[channels]  # PNG's colour types
    rows = np.concatenate([np.zeros((height, 1), np.uint8), pixels.reshape(height, -1)], axis=1)  # 0: no row filter
    header = struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"sRGB", b"\0"), (b"IDAT", zlib.compress(rows.tobytes(), 6)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data)) for name, data in chunks
    )
