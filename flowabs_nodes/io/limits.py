"""Limit the size of pictures: one that is too large is refused before any memory is taken for a pixel."""

from __future__ import annotations

import OpenImageIO as oiio

from flowabs_nodes.errors import ReadError, WriteError
from flowabs_nodes.io.settings import Settings

#: A frame may hold this many times ``Settings.max_pixels`` values (pixels x channels).
CHANNELS_AT_MOST = 8

#: The most channels of a part, and the most parts (pages, subimages) of a file: each of them takes time and memory to
#: open, before anything is asked for. A picture with every pass of a renderer has some hundreds.
MAX_CHANNELS = 4096
MAX_PARTS = 4096


def too_large(width: int, height: int, settings: Settings) -> bool:
    """Return True for a picture of more pixels than ``settings.max_pixels``."""
    return width * height > settings.max_pixels


def check_readable(path: str, spec: oiio.ImageSpec, channels: int, settings: Settings) -> None:
    """Raise ReadError where ``channels`` channels of a part are no picture, or more than this run may read."""
    size = f"{spec.width}x{spec.height}"
    if spec.width < 1 or spec.height < 1 or spec.depth > 1:
        raise ReadError(f"{size} pixels, {spec.depth} deep: not a picture", file=path)
    if too_large(spec.width, spec.height, settings):
        raise ReadError(
            f"{size} is more than {settings.max_pixels:,} pixels",
            code="too-large",
            hint="--max-pixels raises the limit",
            file=path,
        )
    if spec.width * spec.height * channels > CHANNELS_AT_MOST * settings.max_pixels:
        raise ReadError(
            f"{size} pixels of {channels} channels are too many to read at once",
            code="too-large",
            hint="ask for one layer, or raise the limit with --max-pixels",
            file=path,
        )


def check_display_window(width: int, height: int, settings: Settings) -> None:
    """Raise WriteError where a display window of this size is more than this run may write."""
    if too_large(width, height, settings):
        raise WriteError(f"a display window of {width}x{height} is too large", code="too-large")
