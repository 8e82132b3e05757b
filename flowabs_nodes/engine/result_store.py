"""Holds results by key, in a bounded number of bytes."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Container
from typing import NamedTuple

from flowabs_nodes.image import Image

#: The most bytes that a run holds from frame to frame, unless it is told another number: 160 pictures of 1080p RGB.
DEFAULT_BYTES = 4 * 2**30


class StoredKey(NamedTuple):
    """The name of a stored result: its unit's key and its output.

    The frame is part of the name, because a node may look at the frame's number, which is no part of its key.
    """

    key: str
    output: str
    frame: int


class ResultStore:
    """Holds images by key. What was used longest ago goes first where there are too many bytes.

    Parameters
    ----------
    max_bytes
        The most bytes to hold. An image of more is not held at all. Whatever is not held is computed again.
    keeps_all
        False: a run holds only what its later frames will ask for. True: it holds every result until the bytes run out,
        for a session in which anything may be asked for again.

    Attributes
    ----------
    bytes, peak_bytes
        The bytes that are held, and the most that ever were.
    """

    def __init__(self, max_bytes: int = DEFAULT_BYTES, *, keeps_all: bool = False) -> None:
        self.max_bytes = max_bytes
        self.keeps_all = keeps_all
        self.bytes = 0
        self.peak_bytes = 0
        self._images: OrderedDict[StoredKey, Image] = OrderedDict()  # what was used last is at the end

    def __len__(self) -> int:
        return len(self._images)

    def __contains__(self, key: StoredKey) -> bool:
        return key in self._images

    def get(self, key: StoredKey) -> Image | None:
        """Return the image of a key, or None where there is none."""
        image = self._images.get(key)
        if image is not None:
            self._images.move_to_end(key)
        return image

    def put(self, key: StoredKey, image: Image) -> None:
        """Hold an image, unless it has more bytes than all may have."""
        self._drop(key)
        size = image_bytes(image)
        if size > self.max_bytes:
            return
        while self.bytes + size > self.max_bytes:
            self._drop(next(iter(self._images)))
        self._images[key] = image
        self.bytes += size
        self.peak_bytes = max(self.peak_bytes, self.bytes)

    def keep_only(self, keys: Container[StoredKey]) -> None:
        """Drop every image whose key is not among ``keys``."""
        for key in [each for each in self._images if each not in keys]:
            self._drop(key)

    def _drop(self, key: StoredKey) -> None:
        """Drop the image of a key, if there is one."""
        image = self._images.pop(key, None)
        if image is not None:
            self.bytes -= image_bytes(image)


def image_bytes(image: Image) -> int:
    """Return the bytes of an image's pixels, or of the code values and alpha that they are to be decoded from."""
    if image.deferred is None:
        return image.pixels.nbytes
    codes = image.deferred.codes
    return codes.values.nbytes + (0 if codes.under is None else codes.under.nbytes)
