"""Pictures as a host of OpenFX holds them: rows from the lowest up, gaps, windows, depths, and guards around them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

_GUARD = 64  # bytes before and after the pixels, which nobody may touch
_SIGN = 0xA5

DEPTHS = {
    "OfxBitDepthFloat": np.dtype(np.float32),
    "OfxBitDepthHalf": np.dtype(np.float16),
    "OfxBitDepthByte": np.dtype(np.uint8),
    "OfxBitDepthShort": np.dtype(np.uint16),
}


@dataclass
class Layout:
    """How a picture lies in memory.

    ``negative``: the highest row comes first. ``gap``: bytes after each row. ``origin``: x and y, upwards, of the
    lowest left pixel. ``whole``: the region of definition, None for the bounds.
    """

    depth: str = "OfxBitDepthFloat"
    negative: bool = False
    gap: int = 0
    origin: tuple[int, int] = (0, 0)
    premultiplication: str = "OfxImageAlphaPremultiplied"
    whole: tuple[int, int, int, int] | None = None


@dataclass
class Held:
    """A picture in the host's memory, made of an array (H, W, C), the highest row first."""

    array: Any
    layout: Layout = field(default_factory=Layout)

    def __post_init__(self) -> None:
        dtype = DEPTHS[self.layout.depth]
        height, width, channels = self.array.shape
        self.row = width * channels * dtype.itemsize
        self.step = self.row + self.layout.gap
        self.memory = np.full(2 * _GUARD + height * self.step, _SIGN, np.uint8)
        self.pixels = np.ndarray(
            (height, width, channels),
            dtype,
            self.memory,
            _GUARD + (0 if self.layout.negative else (height - 1) * self.step),
            (self.step if self.layout.negative else -self.step, channels * dtype.itemsize, dtype.itemsize),
        )
        self.pixels[...] = self.array.astype(dtype)
        self.before = self.memory.copy()

    @property
    def bounds(self) -> tuple[int, int, int, int]:
        """Return x1, y1, x2, y2 of the pixels, y up."""
        (x, y), (height, width) = self.layout.origin, self.array.shape[:2]
        return x, y, x + width, y + height

    @property
    def address(self) -> int:
        """Return where the lowest left pixel is."""
        return self.pixels[-1:].ctypes.data

    @property
    def row_bytes(self) -> int:
        """Return the bytes from one row to the one above it."""
        return -self.step if self.layout.negative else self.step

    def properties(self, scale: tuple[float, float]) -> dict[str, list[Any]]:
        """Return the properties of the image."""
        component = "OfxImageComponentAlpha" if self.array.shape[2] == 1 else "OfxImageComponentRGBA"
        return {
            "OfxPropType": ["OfxTypeImage"],
            "OfxImageEffectPropPixelDepth": [self.layout.depth],
            "OfxImageEffectPropComponents": [component],
            "OfxImageEffectPropPreMultiplication": [self.layout.premultiplication],
            "OfxImageEffectPropRenderScale": list(scale),
            "OfxImagePropPixelAspectRatio": [1.0],
            "OfxImagePropData": [self.address],
            "OfxImagePropBounds": list(self.bounds),
            "OfxImagePropRegionOfDefinition": list(self.layout.whole or self.bounds),
            "OfxImagePropRowBytes": [self.row_bytes],
            "OfxImagePropField": ["OfxFieldNone"],
        }

    def rows_of(self, window: tuple[int, int, int, int]) -> tuple[slice, slice]:
        """Return the rows and columns of ``pixels`` that a window of the host, y up, covers."""
        x1, _, _, y2 = self.bounds
        return slice(max(0, y2 - window[3]), max(0, y2 - window[1])), slice(max(0, window[0] - x1), window[2] - x1)

    def touched_outside(self, window: tuple[int, int, int, int]) -> bool:
        """Return whether a byte changed that is no pixel of the window: guards, gaps, other pixels."""
        after = self.memory.copy()
        rows, columns = self.rows_of(window)
        mine = np.ndarray(self.pixels.shape, self.pixels.dtype, after, self._offset, self.pixels.strides)
        mine[rows, columns] = np.ndarray(self.pixels.shape, self.pixels.dtype, self.before, self._offset, mine.strides)[
            rows, columns
        ]
        return not np.array_equal(after, self.before)

    @property
    def _offset(self) -> int:
        return self.pixels.ctypes.data - self.memory.ctypes.data
