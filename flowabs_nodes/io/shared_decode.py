"""Decode a file once for all who read it: plate, depth, normals, motion and ids are often layers of one file.

An EXR compresses the channels of a part together, some rows at a time: to read one channel is to decode them all, which
is most of the work. So inside :func:`shared_decodes` the first reader of a file of one part decodes what the others
will ask for too, and each channel is kept, as it is stored, until its last reader has taken it.

What a reader will ask for nobody has to declare: it is called, and stopped at its first question.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.io import formats
from flowabs_nodes.io.formats.declare import Decoder, Planes
from flowabs_nodes.io.limits import check_readable
from flowabs_nodes.simd.bands import over_rows

if TYPE_CHECKING:
    from flowabs_nodes.io.image_file import PictureFile
    from flowabs_nodes.io.settings import Settings

_shares: ContextVar[Mapping[str, _Share] | None] = ContextVar("flowabs_shared_decodes", default=None)
_asking: ContextVar[bool] = ContextVar("flowabs_asking_for_channels", default=False)


@contextmanager
def shared_decodes(readers: Mapping[str, Sequence[Callable[[], object]]]) -> Iterator[None]:
    """Decode each file once inside, for all of its ``readers``: functions that read it, by its path.

    They are called before, without effect: files then raise an exception in place of reading. Nothing is kept on the
    way out.
    """
    shares = {path: _Share(each) for path, each in readers.items() if len(each) > 1}
    token = _shares.set(shares or None)
    try:
        yield
    finally:
        _shares.reset(token)


def seen_by_readers(file: PictureFile, settings: Settings) -> PictureFile:
    """Return an open file as its readers see it: one that shares what is decoded, or only asks for it."""
    if _asking.get():
        return _Asking(file)
    share = (_shares.get() or {}).get(file.path)
    return file if share is None else _Shared(file, share, settings)


class _Asked(Exception):
    """Raised by a file in place of reading ``channels``."""

    def __init__(self, channels: Sequence[str]) -> None:
        super().__init__()
        self.channels = channels


class _Seen:
    """A picture file seen through another one."""

    def __init__(self, file: PictureFile) -> None:
        self.path, self.format, self.specs, self.place = file.path, file.format, file.specs, file.place
        self._file = file


class _Asking(_Seen):
    """A file that tells what it is asked for."""

    def read(self, part: int, channels: Sequence[str]) -> npt.NDArray[np.float32]:
        raise _Asked(channels)

    def read_native(self, part: int, channels: Sequence[str]) -> Planes:
        raise _Asked(channels)


class _Shared(_Seen):
    """A file that gives what has been decoded before."""

    def __init__(self, file: PictureFile, share: _Share, settings: Settings) -> None:
        super().__init__(file)
        self._share = share
        self._settings = settings

    def read(self, part: int, channels: Sequence[str]) -> npt.NDArray[np.float32]:
        planes = self._share.take(self._file, channels, self._settings)
        return self._file.read(part, channels) if planes is None else _interleaved([planes[name] for name in channels])

    def read_native(self, part: int, channels: Sequence[str]) -> Planes:
        planes = self._share.take(self._file, channels, self._settings)
        return self._file.read_native(part, channels) if planes is None else planes


class _Share:
    """The channels of one file that its readers have yet to take; ``readers`` are called to ask which these are."""

    def __init__(self, readers: Sequence[Callable[[], object]]) -> None:
        self._readers = readers
        self._begun = False
        self._state: tuple[int, ...] = ()
        self._planes: Planes = {}
        self._left: Counter[str] = Counter()

    def take(self, file: PictureFile, channels: Sequence[str], settings: Settings) -> Planes | None:
        """Return the planes of ``channels``; None where they are not to be had: then the file itself is read."""
        if not self._begun:
            self._begun = True
            self._begin(file, settings)
        if not all(name in self._planes for name in channels) or _state_of(file.place) != self._state:
            return None
        taken = {name: self._planes[name] for name in channels}
        self._left.subtract(taken.keys())
        for name in taken:
            if not self._left[name]:
                del self._planes[name]
        return taken

    def _begin(self, file: PictureFile, settings: Settings) -> None:
        """Decode what the readers ask for, where several do and the file is one whose channels come together."""
        spec = file.specs[0]
        if len(file.specs) > 1 or not file.format.decoder:
            return
        asked = [each for each in map(_channels_asked, self._readers) if each]
        self._left = Counter(name for each in asked for name in set(each))
        if len(asked) > 1:
            with suppress(FlowabsError):  # too many at once
                check_readable(file.path, spec, len(self._left), settings)
                self._state = _state_of(file.place)
                decode: Decoder = formats.load(file.format.decoder)
                self._planes = decode(file.place, spec, tuple(self._left))


def _channels_asked(reader: Callable[[], object]) -> Sequence[str]:
    """Return what a reader asks for first; nothing where it asks for nothing, or fails, which it will say itself."""
    token = _asking.set(True)
    try:
        reader()
    except _Asked as asked:
        return asked.channels
    except Exception:  # noqa: BLE001 - it is called again, and then its error is somebody's
        pass
    finally:
        _asking.reset(token)
    return ()


def _state_of(place: str) -> tuple[int, ...]:
    """Return what changes when a file does."""
    state = os.stat(place)
    return state.st_dev, state.st_ino, state.st_size, state.st_mtime_ns


def _interleaved(planes: Sequence[npt.NDArray[Any]]) -> npt.NDArray[np.float32]:
    """Return planes (H, W) as (H, W, C) float32; all threads convert."""
    pixels = np.empty((*planes[0].shape, len(planes)), np.float32)

    def convert(first: int, last: int) -> None:
        """Convert some rows."""
        for channel, plane in enumerate(planes):
            pixels[first:last, :, channel] = plane[first:last]

    over_rows(convert, len(pixels))
    return pixels
