"""A picture file that is open: its parts, and their channels as they are in the file.

OpenImageIO reads. It answers hostile files fast and in little memory, while the OpenEXR wheel may need seconds and
gigabytes; the wheel reads only what OpenImageIO cannot, subsampled chroma (:mod:`flowabs_nodes.io.luminance_chroma`).
"""

from __future__ import annotations

import itertools
import os
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes.errors import ReadError
from flowabs_nodes.io import formats
from flowabs_nodes.io.settings import Settings

#: A frame's values (pixels x channels) may be this many times ``Settings.max_pixels``.
CHANNELS_AT_MOST = 8


class PictureFile(Protocol):
    """What reading needs of an open file: ``specs`` has one ImageSpec per part."""

    path: str
    format: str
    specs: tuple[oiio.ImageSpec, ...]

    def read(self, part: int, channels: Sequence[str]) -> npt.NDArray[np.float32]:
        """(H, W, C) float32 of these channels, in this order. Whole numbers are 0..1, but an EXR's stay."""
        ...

    def read_native(self, part: int, channels: Sequence[str]) -> dict[str, npt.NDArray[Any]]:
        """Each channel's plane (H, W) in the file's own data type."""
        ...


@contextmanager
def open_picture(path: str | os.PathLike[str], settings: Settings) -> Iterator[PictureFile]:
    """Open a file whose content is what its name says. Raises ReadError, before memory is taken for any pixel."""
    name = os.fspath(path)
    kind = formats.to_read(name)
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)  # code values must not be multiplied by alpha before they are linear
    source = oiio.ImageInput.open(name, config)
    if source is None:
        why = reason(oiio)
        if kind == "openexr" and "ubsampled" in why:
            yield _luminance_chroma(name, settings)
            return
        raise ReadError(why or "damaged, or not a picture", file=name)
    try:
        if source.format_name() != kind:
            raise ReadError(f"not what its name says: {source.format_name()}", code="bad-format", file=name)
        specs: list[oiio.ImageSpec] = []
        while source.seek_subimage(len(specs), 0):
            specs.append(oiio.ImageSpec(source.spec()))
        reason(source)  # the last seek was one too far
        if not specs:
            raise ReadError("damaged: no picture in the file", file=name)
        if kind == "openexr" and len(specs) == 1 and {"Y", "RY", "BY"} <= set(specs[0].channelnames):
            yield _luminance_chroma(
                name, settings
            )  # not subsampled, or OpenImageIO 3.0, which opens but cannot read it
            return
        yield _OiioFile(name, kind, tuple(specs), source, settings)
    finally:
        source.close()


def _luminance_chroma(path: str, settings: Settings) -> PictureFile:
    from flowabs_nodes.io.luminance_chroma import LuminanceChromaFile

    return LuminanceChromaFile(path, settings)


class _OiioFile:
    def __init__(self, path: str, kind: str, specs: tuple[Any, ...], source: Any, settings: Settings) -> None:
        self.path = path
        self.format = kind
        self.specs = specs
        self._source = source
        self._settings = settings

    def read(self, part: int, channels: Sequence[str]) -> npt.NDArray[np.float32]:
        runs = self._runs(part, channels)
        check_size(self.path, self.specs[part], len(channels), self._settings)
        if len(runs) == 1 and list(channels) == [self.specs[part].channelnames[i] for i in range(*runs[0][:2])]:
            return np.asarray(self._pixels(part, *runs[0]), np.float32)
        spec = self.specs[part]
        pixels = np.empty((spec.height, spec.width, len(channels)), np.float32)
        for begin, end, kind in runs:
            block = self._pixels(part, begin, end, kind)
            for index in range(begin, end):
                pixels[..., list(channels).index(spec.channelnames[index])] = block[..., index - begin]
        return pixels

    def read_native(self, part: int, channels: Sequence[str]) -> dict[str, npt.NDArray[Any]]:
        check_size(self.path, self.specs[part], len(channels), self._settings)
        planes = {}
        for begin, end, kind in self._runs(part, channels, native=True):
            block = self._pixels(part, begin, end, kind)
            for index in range(begin, end):
                planes[self.specs[part].channelnames[index]] = np.ascontiguousarray(block[..., index - begin])
        return planes

    def _runs(self, part: int, channels: Sequence[str], native: bool = False) -> list[tuple[int, int, Any]]:
        """Neighbouring channels that can be read in one go: first, last + 1, and the type to ask for.

        Whole-number channels of an EXR are never read together with others: OpenImageIO would scale them to 0..1.
        """
        spec = self.specs[part]

        def asked(index: int) -> Any:
            kind = spec.channelformat(index)
            return kind if native or (self.format == "openexr" and kind == oiio.TypeUInt32) else oiio.TypeFloat

        runs: list[tuple[int, int, Any]] = []
        indices = sorted(spec.channelnames.index(name) for name in channels)
        for kind, group in itertools.groupby(indices, key=lambda index: str(asked(index))):
            for index in group:
                if runs and runs[-1][1] == index and str(runs[-1][2]) == kind:
                    runs[-1] = (runs[-1][0], index + 1, runs[-1][2])
                else:
                    runs.append((index, index + 1, asked(index)))
        return runs

    def _pixels(self, part: int, begin: int, end: int, kind: Any) -> npt.NDArray[Any]:
        # Not ImageBuf.get_pixels: on a truncated file that gives zeros and no error.
        pixels = self._source.read_image(part, 0, begin, end, kind)
        why = reason(self._source)
        if pixels is None or why:  # a JPEG that is cut short comes with grey pixels and a complaint
            raise ReadError(
                f"damaged or cut short: {why or 'its pixels cannot be decoded'}", code="damaged", file=self.path
            )
        spec = self.specs[part]
        return np.asarray(pixels).reshape(spec.height, spec.width, end - begin)


def check_size(path: str, spec: oiio.ImageSpec, channels: int, settings: Settings) -> None:
    """Raise ReadError where a part is larger than this run may read."""
    size = f"{spec.width}x{spec.height}"
    if spec.width < 1 or spec.height < 1 or spec.depth > 1:
        raise ReadError(f"{size} pixels, {spec.depth} deep: not a picture", file=path)
    if spec.width * spec.height > settings.max_pixels:
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


def reason(source: Any) -> str:
    """What OpenImageIO says went wrong, in one line; empty where nothing did. Clears the error."""
    try:
        text = str(source.geterror())
    except UnicodeDecodeError:  # a damaged header quoted in the message
        return "damaged header"
    first = printable(text.strip().split("\n")[0])[:300]
    return re.sub(r"^(EXR Error \(.*?\): (EXR_ERR_\w+ )?|OpenEXR exception: )", "damaged: ", first)


def printable(text: str) -> str:
    """``text`` for a message: what a hostile header may say cannot move a terminal's cursor."""
    return "".join(sign if sign.isprintable() else "?" for sign in text)
