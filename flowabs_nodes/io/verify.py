"""Verify that a file is whole: every pixel of every part decodes, and is what was written."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, Literal

import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes.errors import ReadError
from flowabs_nodes.io import formats
from flowabs_nodes.io.formats import Format
from flowabs_nodes.io.limits import too_large
from flowabs_nodes.io.oiio_error import reason
from flowabs_nodes.io.pixel_hash import DecodedHash, chunk_hash
from flowabs_nodes.io.settings import Settings

#: Rows that are decoded at a time; EXR's chunks are 1, 16, 32 or 256 rows high.
_ROWS = 256

Flaw = Literal["", "damaged", "changed"]


def is_whole(path: str | os.PathLike[str], settings: Settings | None = None, format: Format | None = None) -> bool:
    """Return True if a file is of the given format and every pixel of every part decodes.

    Without ``format`` it is the one of the file's name. 256 rows are held at a time. A picture of more than
    ``settings.max_pixels`` counts as not whole, and is not decoded.
    """
    return not flaw(path, settings=settings, format=format)


def flaw(
    path: str | os.PathLike[str], pixels: str = "", *, settings: Settings | None = None, format: Format | None = None
) -> Flaw:
    """Return what is wrong with a file: "damaged" where :func:`is_whole` is False, "changed", or "".

    A file that decodes has changed where ``pixels``, a hash that it came with, is not the hash of its pixels.
    """
    expected = format or formats.by_extension(path)
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)  # the values as they are in the file
    source = oiio.ImageInput.open(os.fspath(path), config)
    if source is None:
        reason(oiio)
        return "damaged"
    try:
        if expected is None or source.format_name() != expected.oiio_name:
            return "damaged"
        expected.check(os.fspath(path))
        decoded: DecodedHash | None = None
        part = 0
        while source.seek_subimage(part, 0):
            spec = source.spec()
            if too_large(spec.width, spec.height, settings or Settings()):
                return "damaged"
            if pixels and expected.hashed == "decoded":
                decoded = DecodedHash(spec.width, spec.height, spec.nchannels)
            if not decodes(source, spec, part, decoded.update if decoded else _ignore) or reason(source):
                return "damaged"
            part += 1
        reason(source)  # the last seek was one too far
        if part == 0:
            return "damaged"
        if not pixels:
            return ""
        return "" if (decoded.hexdigest() if decoded else _chunk_hash(path)) == pixels else "changed"
    except ReadError:
        return "damaged"
    finally:
        source.close()


def _chunk_hash(path: str | os.PathLike[str]) -> str:
    """Return the hash of an EXR's chunks; "" where it has none."""
    try:
        with open(path, "rb") as file:
            return chunk_hash(file)
    except (OSError, ValueError):
        return ""


def _ignore(rows: npt.NDArray[Any]) -> None:
    """Do nothing with decoded rows."""


def decodes(source: Any, spec: oiio.ImageSpec, part: int, use: Callable[[npt.NDArray[Any]], None] = _ignore) -> bool:
    """Return True if OpenImageIO decodes every scanline or tile of a part, or its deep samples.

    ``use`` is handed the pixels, some rows at a time, in order and in the file's data type; deep samples are not.
    """
    if spec.deep:
        return source.read_native_deep_image(part, 0) is not None
    end = spec.y + spec.height
    step = _ROWS
    if spec.tile_width:
        step = max(spec.tile_height, _ROWS // spec.tile_height * spec.tile_height)
    for y in range(spec.y, end, step):
        last = min(y + step, end)
        if spec.tile_width:
            across = spec.x, spec.x + spec.width
            rows = source.read_tiles(part, 0, *across, y, last, 0, 1, 0, spec.nchannels, spec.format)
        else:
            rows = source.read_scanlines(part, 0, y, last, 0, 0, spec.nchannels, spec.format)
        if rows is None:
            return False
        use(rows)
    return True
