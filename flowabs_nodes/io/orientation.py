"""Turn photographs upright that a camera stored lying on their side, and scans that run from bottom to top."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

#: Exif orientation -> (swap x and y first, then mirror vertically, then mirror horizontally).
_TURNS = {
    2: (False, False, True),
    3: (False, True, True),
    4: (False, True, False),
    5: (True, False, False),
    6: (True, False, True),
    7: (True, True, True),
    8: (True, True, False),
}


def upright(pixels: npt.NDArray[Any], spec: oiio.ImageSpec) -> npt.NDArray[Any]:
    """Return (H, W, C) pixels turned as the Orientation of ``spec`` says; ``spec`` is changed to match."""
    turn = _TURNS.get(spec.get_int_attribute("Orientation", 1))
    if turn is None:
        return pixels
    swap, down, across = turn
    pixels = np.swapaxes(pixels, 0, 1) if swap else pixels
    pixels = np.ascontiguousarray(pixels[:: -1 if down else 1, :: -1 if across else 1])
    spec.height, spec.width = pixels.shape[:2]
    spec.full_height, spec.full_width = pixels.shape[:2]
    spec.x = spec.y = spec.full_x = spec.full_y = 0
    spec.attribute("Orientation", 1)
    return pixels
