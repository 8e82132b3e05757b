"""The parts of an image: a window, the file it came from, the source of its pixels; and whether parts fit together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol

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
    def codes(self) -> Codes:
        """Return the code values that pixels are decoded from; the object itself, where decoding is all to be done."""

    def decode(self, colorspace: ColorSpace) -> Array:
        """Return the pixels, (H, W, 3), or premultiplied (H, W, 4), scene-linear in ``colorspace``."""


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


def check_parts(pixels: Array | None, spec: oiio.ImageSpec, type: str) -> None:
    """Raise ArgumentError unless an image of this type can have these channels, and these pixels if they are there."""
    declared = pixel_type(type)
    names = tuple(spec.channelnames)
    if declared.channels and names not in declared.channels:
        found = f"not {','.join(names)}"
        expected = declared.expected_channels()
        raise ArgumentError(f"{declared.an_image} has the channels {expected}, {found}", parameter="spec")
    if pixels is not None and pixels.shape != (spec.height, spec.width, len(names)):
        raise ArgumentError(
            f"pixels of shape {pixels.shape} do not fit a data window of {spec.width}x{spec.height} "
            f"with {len(names)} channels",
            parameter="pixels",
        )
