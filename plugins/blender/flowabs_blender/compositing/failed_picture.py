"""Makes the picture that stands for a result that could not be computed: nobody takes it for one, and it says why."""

from __future__ import annotations

import textwrap

import numpy as np
import OpenImageIO as oiio

from flowabs_nodes import Image

_DARK, _BRIGHT = (0.12, 0.0, 0.09, 1.0), (0.4, 0.0, 0.3, 1.0)
_LETTER = 0.55  # of the height of a line


def failed_picture(width: int, height: int, text: str) -> Image:
    """Return stripes with a text, colour of the size (height, width)."""
    stripe = max(4, height // 24)
    rows, columns = np.mgrid[:height, :width]
    bright = ((rows + columns) // stripe % 2 == 0)[..., None]
    pixels = np.where(bright, np.float32(_BRIGHT), np.float32(_DARK)).astype(np.float32)
    return Image.from_array(_written(pixels, text), encoding="linear", alpha="premultiplied")


def _written(pixels: np.ndarray, text: str) -> np.ndarray:
    """Return pixels with a text, in lines over the whole width; without it where OpenImageIO has no letters."""
    height, width = pixels.shape[:2]
    size = max(8, min(width // 40, height // 16))
    lines = textwrap.wrap(text, max(8, int(width * 0.92 / (size * _LETTER))), break_long_words=True)
    spec = oiio.ImageSpec(width, height, 4, oiio.FLOAT)
    picture = oiio.ImageBuf(spec)
    picture.set_pixels(oiio.ROI.All, np.ascontiguousarray(pixels))
    for number, line in enumerate(lines, start=1):
        oiio.ImageBufAlgo.render_text(
            picture, int(width * 0.04), int(size * 1.5) * number, line, size, "", (1, 1, 1, 1)
        )
    return np.asarray(picture.get_pixels(oiio.FLOAT), np.float32)
