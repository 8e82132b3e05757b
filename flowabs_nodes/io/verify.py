"""Verify that a file is whole: every pixel of every part decodes."""

from __future__ import annotations

import os
from typing import Any

import OpenImageIO as oiio

from flowabs_nodes.errors import ReadError
from flowabs_nodes.io import formats
from flowabs_nodes.io.formats import Format
from flowabs_nodes.io.limits import too_large
from flowabs_nodes.io.oiio_error import reason
from flowabs_nodes.io.settings import Settings

#: Rows that are decoded at a time; EXR's chunks are 1, 16, 32 or 256 rows high.
_ROWS = 256


def is_whole(path: str | os.PathLike[str], settings: Settings | None = None, format: Format | None = None) -> bool:
    """Return True if a file is of the given format and every pixel of every part decodes.

    Without ``format`` it is the one of the file's name. 256 rows are held at a time. A picture of more than
    ``settings.max_pixels`` counts as not whole, and is not decoded.
    """
    source = oiio.ImageInput.open(os.fspath(path))
    if source is None:
        reason(oiio)
        return False
    try:
        expected = format or formats.by_extension(path)
        if expected is None or source.format_name() != expected.oiio_name:
            return False
        expected.check(os.fspath(path))
        part = 0
        while source.seek_subimage(part, 0):
            spec = source.spec()
            if too_large(spec.width, spec.height, settings or Settings()):
                return False
            if not _decodes(source, spec, part) or reason(source):
                return False
            part += 1
        reason(source)  # the last seek was one too far
        return part > 0
    except ReadError:
        return False
    finally:
        source.close()


def _decodes(source: Any, spec: oiio.ImageSpec, part: int) -> bool:
    """Return True if OpenImageIO decodes every scanline or tile of a part, or its deep samples."""
    if spec.deep:
        return source.read_native_deep_image(part, 0) is not None
    end = spec.y + spec.height
    if spec.tile_width:
        step = max(spec.tile_height, _ROWS // spec.tile_height * spec.tile_height)
        across = spec.x, spec.x + spec.width
        return all(
            source.read_tiles(part, 0, *across, y, min(y + step, end), 0, 1, 0, spec.nchannels, spec.format) is not None
            for y in range(spec.y, end, step)
        )
    return all(
        source.read_scanlines(part, 0, y, min(y + _ROWS, end), 0, 0, spec.nchannels, spec.format) is not None
        for y in range(spec.y, end, _ROWS)
    )
