"""Open a picture file, and read channels of its parts as they are in the file.

OpenImageIO reads. It answers hostile files fast and in little memory, while the OpenEXR module may need seconds and
gigabytes. Only a file that OpenImageIO cannot read is opened by the reader that its format names.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes.errors import FlowabsError, ReadError
from flowabs_nodes.image.header_text import with_readable_texts
from flowabs_nodes.io import formats
from flowabs_nodes.io.confined import held_file
from flowabs_nodes.io.formats import Format
from flowabs_nodes.io.limits import MAX_PARTS, check_readable, too_large
from flowabs_nodes.io.oiio_error import reason
from flowabs_nodes.io.other_parts import check_other_parts
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.io.shared_decode import seen_by_readers
from flowabs_nodes.simd.bands import over_rows


class PictureFile(Protocol):
    """An open file, as reading needs it: ``specs`` has one ImageSpec per part."""

    path: str
    format: Format
    specs: tuple[oiio.ImageSpec, ...]
    #: A path that leads to the very file while it is open, even where its own leads elsewhere by now.
    place: str

    def read(self, part: int, channels: Sequence[str]) -> npt.NDArray[np.float32]:
        """Return (H, W, C) float32 of these channels, in this order; whole numbers as ``format.integers`` says."""
        ...

    def read_native(self, part: int, channels: Sequence[str]) -> dict[str, npt.NDArray[Any]]:
        """Return each channel's plane (H, W) in the file's own data type."""
        ...


@contextmanager
def open_picture(path: str | os.PathLike[str], settings: Settings) -> Iterator[PictureFile]:
    """Open a file whose content is what its name says. Raises ReadError, before memory is taken for any pixel.

    Raises CommandError for a file outside of ``settings.root``.
    """
    name = os.fspath(path)
    with ExitStack() as held:
        try:
            place = held.enter_context(held_file(name, settings.root))
        except FileNotFoundError:
            raise ReadError("no such file", code="missing-file", file=name) from None
        except OSError as error:
            raise ReadError(f"cannot be read: {error.strerror or error}", file=name) from error
        try:
            with _opened(name, place, settings) as file:
                yield seen_by_readers(file, settings)
        except FlowabsError as error:
            if error.file == place:
                error.file = name
            error.message = error.message.replace(place, name)
            raise


@contextmanager
def _opened(name: str, place: str, settings: Settings) -> Iterator[PictureFile]:
    """Open the file at ``place``, which is called ``name``; errors may call it either."""
    format = formats.to_read(name, place)
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)  # code values must not be multiplied by alpha before they are linear
    source = oiio.ImageInput.open(place, config)
    if source is None:
        problem = reason(oiio)
        if place != name:  # which has no extension: without it OpenImageIO does not say what is wrong
            oiio.ImageInput.open(name, config)
            problem = reason(oiio) or problem
        if reader := format.reader((), problem):
            yield formats.load(reader)(name, place, format, settings)
            return
        raise ReadError(problem or "damaged, or not a picture", file=name)
    try:
        if source.format_name() != format.oiio_name:
            raise ReadError(f"not what its name says: {source.format_name()}", code="bad-format", file=name)
        specs: list[oiio.ImageSpec] = []
        while source.seek_subimage(len(specs), 0):
            if len(specs) == MAX_PARTS:
                raise ReadError(f"a file of more than {MAX_PARTS:,} parts is not opened", code="too-large", file=name)
            specs.append(with_readable_texts(source.spec()))
        reason(source)  # the last seek was one too far
        if not specs:
            raise ReadError("damaged: no picture in the file", file=name)
        format.check(place)
        format.complete(place, specs[0])
        if reader := format.reader(specs, ""):
            yield formats.load(reader)(name, place, format, settings)
        else:
            yield _OiioFile(name, place, format, tuple(specs), source, settings)
    finally:
        source.close()


def check_picture(path: str | os.PathLike[str], settings: Settings) -> None:
    """Raise ReadError for a file that is no picture, or a too large one, from its first bytes and its header alone.

    A damaged header is left to whoever reads the file.
    """
    formats.to_read(path)
    source = oiio.ImageInput.open(os.fspath(path))
    if source is None:
        reason(oiio)
        return
    spec = source.spec()
    source.close()
    if too_large(spec.width, spec.height, settings):
        check_readable(os.fspath(path), spec, 1, settings)


class _Run(NamedTuple):
    """Neighbouring channels, from ``begin`` up to but not with ``end``, that are read in one go as ``data_type``."""

    begin: int
    end: int
    data_type: Any


class _OiioFile:
    """A file that OpenImageIO has open as ``source``."""

    def __init__(
        self, path: str, place: str, format: Format, specs: tuple[Any, ...], source: Any, settings: Settings
    ) -> None:
        self.path = path
        self.place = place
        self.format = format
        self.specs = specs
        self._source = source
        self._settings = settings

    def read(self, part: int, channels: Sequence[str]) -> npt.NDArray[np.float32]:
        runs = self._runs(part, channels)
        check_readable(self.path, self.specs[part], len(channels), self._settings)
        names = self.specs[part].channelnames
        if len(runs) == 1 and list(channels) == list(names[runs[0].begin : runs[0].end]):
            return _as_floats(self._pixels(part, runs[0]))
        spec = self.specs[part]
        pixels = np.empty((spec.height, spec.width, len(channels)), np.float32)
        for run in runs:
            block = self._pixels(part, run)
            for index in range(run.begin, run.end):
                pixels[..., list(channels).index(names[index])] = block[..., index - run.begin]
        return pixels

    def read_native(self, part: int, channels: Sequence[str]) -> dict[str, npt.NDArray[Any]]:
        check_readable(self.path, self.specs[part], len(channels), self._settings)
        names = self.specs[part].channelnames
        planes = {}
        for run in self._runs(part, channels, native=True):
            block = self._pixels(part, run)
            for index in range(run.begin, run.end):
                planes[names[index]] = np.ascontiguousarray(block[..., index - run.begin])
        return planes

    def _runs(self, part: int, channels: Sequence[str], native: bool = False) -> list[_Run]:
        """Group channels into runs of one data type.

        Ids are never in a run with other numbers: OpenImageIO would scale them to 0..1. Half floats alone are read as
        they are: our threads convert them faster.
        """
        spec = self.specs[part]
        indices = sorted(spec.channelnames.index(name) for name in channels)
        all_half = all(spec.channelformat(index) == oiio.TypeHalf for index in indices)

        def wanted(index: int) -> Any:
            stored = spec.channelformat(index)
            exact = self.format.integers == "exact" and stored == oiio.TypeUInt32
            return stored if native or exact or all_half else oiio.TypeFloat

        runs: list[_Run] = []
        for data_type, group in itertools.groupby(indices, key=lambda index: str(wanted(index))):
            for index in group:
                if runs and runs[-1].end == index and str(runs[-1].data_type) == data_type:
                    runs[-1] = runs[-1]._replace(end=index + 1)
                else:
                    runs.append(_Run(index, index + 1, wanted(index)))
        return runs

    def _pixels(self, part: int, run: _Run) -> npt.NDArray[Any]:
        """Return (H, W, C) of a run's channels. Raises ReadError where they cannot all be decoded."""
        # Not ImageBuf.get_pixels: on a truncated file that gives zeros and no error.
        pixels = self._source.read_image(part, 0, run.begin, run.end, run.data_type)
        problem = reason(self._source)
        if pixels is None or problem:  # a JPEG that is cut short comes with grey pixels and a complaint
            raise ReadError(
                f"damaged or cut short: {problem or 'its pixels cannot be decoded'}", code="damaged", file=self.path
            )
        check_other_parts(self.place, self.specs, part, self._settings)
        spec = self.specs[part]
        return np.asarray(pixels).reshape(spec.height, spec.width, run.end - run.begin)


def _as_floats(pixels: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
    """Return (H, W, C) pixels as float32; all threads convert half floats."""
    if pixels.dtype != np.float16:
        return np.asarray(pixels, np.float32)
    floats = np.empty(pixels.shape, np.float32)

    def convert(first: int, last: int) -> None:
        """Convert some rows."""
        floats[first:last] = pixels[first:last]

    over_rows(convert, len(pixels))
    return floats
