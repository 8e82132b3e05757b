"""Read EXR files of luminance and subsampled chroma (channels Y, RY, BY), which OpenImageIO does not read."""

from __future__ import annotations

import contextlib
import io
import os
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import OpenEXR
import OpenImageIO as oiio

from flowabs_nodes import color
from flowabs_nodes.array_types import Array
from flowabs_nodes.color import detect
from flowabs_nodes.errors import ReadError
from flowabs_nodes.io import attributes
from flowabs_nodes.io.formats import Format
from flowabs_nodes.io.limits import check_readable
from flowabs_nodes.io.oiio_error import printable
from flowabs_nodes.io.settings import Settings

#: The filter by which OpenEXR's ``RgbaYca`` reconstructs chroma, one half of it: weights 1, 3, 5 .. 13 pixels away.
_TAPS = (0.627123, -0.186077, 0.087929, -0.043159, 0.019597, -0.007540, 0.002128)

#: A file whose pixels would take more than this many times its size is refused: the OpenEXR module would just try.
_SHRINKS_AT_MOST = 2000


class LuminanceChromaFile:
    """A one-part EXR with Y, RY = (R - Y)/Y, BY = (B - Y)/Y and maybe A, seen as one with R, G, B[, A].

    It can be read like any :class:`flowabs_nodes.io.image_file.PictureFile`. Raises ReadError where the header is
    damaged, the picture too large, or another channel is there.
    """

    def __init__(self, path: str, place: str, format: Format, settings: Settings) -> None:
        self.path = path
        self.place = place
        self.format = format
        self._settings = settings
        header, channels = self._open(header_only=True)
        missing = {"Y", "RY", "BY"} - set(channels)
        if missing or set(channels) - {"Y", "RY", "BY", "A"}:
            raise self._error(
                f"channels {printable(','.join(sorted(channels)))} with subsampling; only Y,RY,BY[,A] can be read so"
            )
        low, high = header["dataWindow"]
        full_low, full_high = header["displayWindow"]
        spec = oiio.ImageSpec(int(high[0] - low[0]) + 1, int(high[1] - low[1]) + 1, 4 if "A" in channels else 3, "half")
        spec.x, spec.y = int(low[0]), int(low[1])
        spec.full_x, spec.full_y = int(full_low[0]), int(full_low[1])
        spec.full_width, spec.full_height = (int(b - a) + 1 for a, b in zip(full_low, full_high, strict=True))
        attributes.to_spec(header, spec)
        compression = header["compression"].name.removesuffix("_COMPRESSION").lower()
        spec.attribute("compression", "none" if compression == "no" else compression)
        check_readable(path, spec, 4, settings)
        if spec.width * spec.height * 2 > _SHRINKS_AT_MOST * os.path.getsize(place):
            raise self._error(f"{spec.width}x{spec.height} pixels cannot be in a file this small")
        self.specs: tuple[oiio.ImageSpec, ...] = (spec,)

    def read(self, part: int, channels: Sequence[str]) -> Array:
        """Return (H, W, C) float32 of R, G, B, A in any order."""
        planes = self.read_native(part, channels)
        return np.stack([planes[name].astype(np.float32) for name in channels], axis=2)

    def read_native(self, part: int, channels: Sequence[str]) -> dict[str, npt.NDArray[Any]]:
        """Return planes (H, W): R, G, B float32 as the reconstruction gives them, A in the file's own data type."""
        spec = self.specs[part]
        _, found = self._open(header_only=False)
        y = found["Y"].pixels.astype(np.float32)
        if y.shape != (spec.height, spec.width):
            raise self._error("luminance itself is subsampled")
        ry, by = (self._full(found[name], name) for name in ("RY", "BY"))
        weights = color.luminance(np.eye(3, dtype=np.float32)[None], detect(spec).space)[0]
        planes: dict[str, npt.NDArray[Any]] = {"R": (ry + 1) * y, "B": (by + 1) * y}
        planes["G"] = (y - weights[0] * planes["R"] - weights[2] * planes["B"]) / weights[1]
        if "A" in found:
            planes["A"] = found["A"].pixels
        return {name: planes[name] for name in channels}

    def _open(self, header_only: bool) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the header, and the channels by name; without pixels for ``header_only``. Raises ReadError."""
        try:
            with contextlib.redirect_stdout(io.StringIO()):  # it prints its warnings there
                file = OpenEXR.File(self.place, separate_channels=True, header_only=header_only)
            if len(file.parts) != 1:  # none: it could not decode the pixels, and only warned
                raise self._error("damaged or cut short" if not file.parts else "several parts of subsampled channels")
            header = dict(file.parts[0].header)
            channels = header["channels"] if header_only else file.parts[0].channels.values()
            return header, {channel.name: channel for channel in channels}
        except (RuntimeError, ValueError, KeyError, ArithmeticError) as error:
            # ValueError: a header that is no UTF-8, too; ArithmeticError: a rate of 24/0
            raise self._error(f"damaged: {error}") from None

    def _full(self, channel: Any, name: str) -> Array:
        """Return a chroma channel, (H, W). EXR has corner and size of the data window multiples of its sampling."""
        plane: Array = channel.pixels.astype(np.float32)
        for axis, step in enumerate((channel.ySampling, channel.xSampling)):
            if step not in (1, 2):
                steps = f"{channel.xSampling}x{channel.ySampling}"
                raise self._error(f"channel {name} is sampled every {steps} pixels; 1 and 2 can be read")
            if step == 2:
                plane = np.moveaxis(_upsampled(np.moveaxis(plane, axis, 0)), 0, axis)
        return plane

    def _error(self, text: str) -> ReadError:
        """Return the error that names this file."""
        return ReadError(text, code="damaged" if "damaged" in text else None, file=self.path)


def _upsampled(samples: Array) -> Array:
    """Return twice as many samples along axis 0: the given at even places, filtered ones between; ends are repeated."""
    count = len(samples)
    result = np.zeros((2 * count, *samples.shape[1:]), np.float32)
    result[0::2] = samples
    left = np.arange(count)
    for step, weight in enumerate(_TAPS):
        before = samples[np.maximum(left - step, 0)]
        after = samples[np.minimum(left + 1 + step, count - 1)]
        result[1::2] += np.float32(weight) * (before + after)
    return result
