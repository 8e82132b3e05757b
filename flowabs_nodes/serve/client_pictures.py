"""A client's pictures: arrays, what they mean, and where in the memory that both processes see they lie."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.serve.client_memory import Memories, Place

_CHANNELS = {1: "A", 3: "RGB", 4: "RGBA"}


@dataclass(frozen=True, eq=False)
class Pixels:
    """An array of a picture, and what it means.

    Attributes
    ----------
    array
        (H, W, C) float32, float16, uint8 or uint16 with channels R, G, B[, A], or (H, W) of one alone, a mask.
    colorspace
        The name of its scene-linear space or encoding, as ``flowabs colorspaces`` lists them.
    alpha
        "premultiplied", "straight", or "opaque": its fourth channel means nothing.
    rows
        "top-down", or "bottom-up" where the first row is the lowest.
    window
        x, y of the first pixel in the full picture, y down.
    display
        (x, y, width, height) of the full picture; None: that of the pixels.
    """

    array: npt.NDArray[Any]
    colorspace: str = "lin_rec709"
    alpha: str = "premultiplied"
    rows: str = "top-down"
    window: tuple[int, int] = (0, 0)
    display: tuple[int, int, int, int] | None = None


def shared(
    picture: npt.NDArray[Any] | Pixels, memories: Memories, borrowed: ExitStack, *, fill: bool = False
) -> tuple[dict[str, Any], Callable[[], None] | None]:
    """Return a picture as a request says it, and what copies it back from memory that had to be borrowed.

    With ``fill`` the borrowed memory holds what the array does.
    """
    pixels = picture if isinstance(picture, Pixels) else Pixels(picture)
    array = pixels.array
    if not isinstance(array, np.ndarray) or array.ndim not in (2, 3) or array.size == 0:
        found = f"{array.dtype} {array.shape}" if isinstance(array, np.ndarray) else type(array).__name__
        raise ArgumentError(f"picture: expected an array (H, W) or (H, W, C), found {found}", parameter="picture")
    array = array if array.ndim == 3 else array[..., None]
    height, width, count = array.shape
    if count not in _CHANNELS:
        raise ArgumentError(f"picture: expected 1, 3 or 4 channels, found {count}", parameter="picture")
    place = memories.place(array) if array.strides[1:] == (count * array.itemsize, array.itemsize) else None
    copy = None
    if place is None:
        number, bytes_ = borrowed.enter_context(memories.borrowed(array.nbytes))
        there = np.ndarray(array.shape, array.dtype, bytes_)
        if fill:
            np.copyto(there, array)
        else:
            copy = _copy(array, there)
        place, row_bytes = Place(number, 0), there.strides[0]
    else:
        row_bytes = array.strides[0]
    words = {
        **place._asdict(),
        "width": width,
        "height": height,
        "channels": _CHANNELS[count],
        "dtype": array.dtype.name,
        "row_bytes": row_bytes,
        "rows": pixels.rows,
        "colorspace": pixels.colorspace,
        "alpha": pixels.alpha,
        "window": list(pixels.window),
        "display": None if pixels.display is None else list(pixels.display),
    }
    return words, copy


def _copy(array: npt.NDArray[Any], there: npt.NDArray[Any]) -> Callable[[], None]:
    """Return a function that copies ``there`` to ``array``."""
    return lambda: np.copyto(array, there)
