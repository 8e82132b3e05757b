"""What all functions have in common: a ``dst`` to fill, a region, threads, and errors as ImageBufAlgo has them."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import nullcontext

import OpenImageIO as oiio

from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image import Image
from flowabs_nodes.simd.bands import limited

_said = threading.local()


class FailedImageBuf(oiio.ImageBuf):
    """An ImageBuf without pixels that says why it has none; functions that are given it fail in their turn."""

    def __init__(self, message: str) -> None:
        super().__init__()
        self._message = message

    @property
    def has_error(self) -> bool:
        """Return True until the error has been fetched."""
        return bool(self._message)

    def geterror(self, clear: bool = True) -> str:
        """Return what went wrong, and forget it unless ``clear`` is False."""
        message = self._message
        if clear:
            self._message = ""
        return message


def geterror() -> str:
    """Return what the last function that failed in this thread had to say, once; "" where none has failed."""
    message: str = getattr(_said, "message", "")
    _said.message = ""
    return message


def delivered(
    name: str,
    compute: Callable[[], Image],
    dst: oiio.ImageBuf | None,
    roi: oiio.ROI | None,
    nthreads: int,
) -> oiio.ImageBuf | bool:
    """Compute an image and deliver it as ImageBufAlgo does.

    Parameters
    ----------
    name
        The function's name, for errors.
    dst
        Where the result goes; None: an ImageBuf of its own, of float pixels. As in ImageBufAlgo, one that has pixels
        keeps its format and windows, and is written where both are; one without is made to fit.
    roi
        The pixels to deliver; the whole picture is looked at all the same. None: all.
    nthreads
        How many threads the filter uses; 0: as many as there are processors.

    Returns
    -------
    The result; with a ``dst``, whether it was filled. Where something was wrong with the pictures or the parameters it
    is an ImageBuf that has an error, or False, and :func:`geterror` says what.
    """
    try:
        with limited(nthreads) if nthreads else nullcontext():
            result = compute().to_imagebuf()
    except FlowabsError as error:
        return _failed(f"{name}(): {error}", dst)
    part = oiio.ROI() if roi is None else roi
    if roi is not None and not _meets(roi, result.roi):
        return _failed(
            f"{name}(): no pixels of the picture, {_words(result.roi)}, lie in the region {_words(roi)}", dst
        )
    if dst is None:
        dst = result if roi is None else oiio.ImageBuf()
        if roi is not None and not oiio.ImageBufAlgo.crop(dst, result, part):
            return _failed(f"{name}(): {dst.geterror()}", None)
        return dst
    if not oiio.ImageBufAlgo.copy(dst, result, roi=part):
        _said.message = f"{name}(): {dst.geterror(False)}"
        return False
    return True


def _failed(message: str, dst: oiio.ImageBuf | None) -> oiio.ImageBuf | bool:
    """Remember what went wrong, and return what a function that fails returns."""
    _said.message = message
    return FailedImageBuf(message) if dst is None else False


def _meets(one: oiio.ROI, other: oiio.ROI) -> bool:
    """Return whether two regions have pixels in common; a region that is not defined is all."""
    if not one.defined:
        return True
    common = oiio.intersection(one, other)
    return bool(common.width > 0 and common.height > 0)


def _words(roi: oiio.ROI) -> str:
    """Return a region in words: "640x480+0-10"."""
    return f"{roi.width}x{roi.height}{roi.xbegin:+d}{roi.ybegin:+d}"
