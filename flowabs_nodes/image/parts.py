"""The parts of an image: a window, the file it came from, the source of its pixels; and whether parts fit together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.port_types import PortType, pixel_type

if TYPE_CHECKING:
    from flowabs_nodes.color import ColorSpace
    from flowabs_nodes.color.codes import Codes


class Window(NamedTuple):
    """A rectangle of pixels: its upper left corner, which may be negative, and its size."""

    x: int
    y: int
    width: int
    height: int


class PixelSource(Protocol):
    """Pixels that are computed when they are asked for, from code values: ``Codes``, or finishing's ``Deferred``."""

    @property
    def shape(self) -> tuple[int, int, int]:
        """Return the shape of the pixels, (H, W, 3) or (H, W, 4)."""

    @property
    def codes(self) -> Codes:
        """Return the code values that pixels are decoded from; the object itself, where decoding is all to be done."""

    def decode(self, colorspace: ColorSpace) -> Array:
        """Return the pixels, (H, W, 3), or premultiplied (H, W, 4), scene-linear in ``colorspace``."""

    def decode_rows(self, first: int, last: int, colorspace: ColorSpace) -> Array:
        """Return the rows ``first`` .. ``last`` - 1 of the pixels, in memory that nobody else has."""


@dataclass(frozen=True)
class Origin:
    """The file that an image was read from."""

    file: str
    part: int = 0  # index of the part in the file
    layer: str = ""
    channels: tuple[str, ...] = ()  # the file's names of the channels that were read
    alpha: str = ""  # the file's alpha, where the image leaves it out (ignored, or 0 in every pixel), for writing


class Parts(NamedTuple):
    """What an image is made of, but for its colour space."""

    pixels: Array  # (H, W, C) in the type's dtype, C-contiguous
    spec: oiio.ImageSpec
    type: PortType


def as_pixels(array: Any, type: str) -> npt.NDArray[Any]:
    """Return an array as C-contiguous pixels in the type's dtype, not copied if it is that already.

    ArgumentError for anything but an array of real numbers, and for ids that were calculated with.
    """
    if not isinstance(array, np.ndarray) or array.dtype.kind not in "fiub":
        found = f"dtype {array.dtype}" if isinstance(array, np.ndarray) else array.__class__.__name__
        message = f"expected an array of real numbers, found {found}"
        raise ArgumentError(message, code="wrong-type", parameter="pixels")
    return pixel_type(type).cast(array)


def check_parts(pixels: Array | PixelSource, spec: oiio.ImageSpec, type: str) -> None:
    """Raise ArgumentError unless an image of this type can have these channels, and pixels of this shape."""
    declared = pixel_type(type)
    names = tuple(spec.channelnames)
    if declared.channels and names not in declared.channels:
        found = f"not {','.join(names)}"
        expected = declared.expected_channels()
        raise ArgumentError(f"{declared.an_image} has the channels {expected}, {found}", parameter="spec")
    shape = getattr(pixels, "shape", None)
    if shape != (spec.height, spec.width, len(names)):
        raise ArgumentError(
            f"pixels of shape {shape} do not fit a data window of {spec.width}x{spec.height} "
            f"with {len(names)} channels",
            parameter="pixels",
        )


def with_channels(spec: oiio.ImageSpec, names: tuple[str, ...]) -> oiio.ImageSpec:
    """Return a copy of ``spec`` with these channels, all of its one data type."""
    copy = oiio.ImageSpec(spec)
    copy.nchannels = len(names)
    copy.channelnames = names
    copy.channelformats = ()
    copy.alpha_channel = names.index("A") if "A" in names else -1
    copy.z_channel = -1
    return copy
