"""Gather one frame that is ready to be written: the image, its layers, and how they are to be stored."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes.array_types import Array
from flowabs_nodes.color.display import DisplayView, find_view
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.file_choices import COMPRESSIONS, DATA_TYPES
from flowabs_nodes.image import Image, Window
from flowabs_nodes.io import formats
from flowabs_nodes.io.formats import Format
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.port_types import pixel_type

Say = Callable[[str], None]


@dataclass(frozen=True)
class Picture:
    """One frame as the node ``write`` hands it over; the file's format is known only when it is saved.

    Attributes
    ----------
    image
        The main image: its windows and metadata are the file's.
    layers
        Further images by layer name, on the same data window.
    data_type, compression, keep_layers, colorspace, metadata, display, view
        As the parameters of ``write``.
    settings
        The run's limits and OCIO config.
    """

    image: Image
    layers: Mapping[str, Image] = field(default_factory=dict)
    data_type: str = "auto"
    compression: str = "auto"
    keep_layers: str = ""
    colorspace: str = "plate"
    metadata: Mapping[str, str | float] = field(default_factory=dict)
    settings: Settings = field(default_factory=Settings)
    display: str = ""
    view: str = ""

    @property
    def shown_by(self) -> DisplayView | None:
        """Return the display and view that colours are encoded for; None where ``colorspace`` says the encoding."""
        if not (self.display or self.view):
            return None
        return find_view(self.display, self.view, self.settings.ocio)

    @property
    def plate_format(self) -> Format | None:
        """Return the format of the file that the image was read from; None where it was not read from a file."""
        return formats.by_extension(self.image.origin.file) if self.image.origin is not None else None


def build_picture(
    image: Image,
    layers: Mapping[str, Image] | None = None,
    *,
    data_type: str = "auto",
    compression: str = "auto",
    keep_layers: str = "",
    colorspace: str = "plate",
    metadata: Mapping[str, str | float] | None = None,
    settings: Settings | None = None,
    display: str = "",
    view: str = "",
    warn: Say = lambda text: None,
) -> Picture:
    """Return a frame to save (:func:`flowabs_nodes.io.write.save`); layers are brought to the image's data window.

    The parameters are those of ``write``. ``warn`` is told of a layer whose data window is not the image's. Raises
    ArgumentError for a ``data_type`` or ``compression`` that there is not, and for a ``colorspace`` beside a view.
    """
    for name, value, choices in (("data_type", data_type, DATA_TYPES), ("compression", compression, COMPRESSIONS)):
        if value not in choices:
            raise ArgumentError(f"{name}: expected one of {', '.join(choices)}, found {value!r}", parameter=name)
    if colorspace != "plate" and (display or view):
        raise ArgumentError(
            f"colorspace: {colorspace!r} and a display or view cannot both be the file's encoding: set one",
            parameter="colorspace",
        )
    placed = {}
    for name, layer in (layers or {}).items():
        if layer.data_window != image.data_window:
            warn(f"layer {name}: its data window is not the image's; it is cut, or 0 where it has no pixels")
        placed[name] = layer.on_window(image.data_window)
    encoding = (data_type, compression, keep_layers, colorspace, dict(metadata or {}))
    return Picture(image, placed, *encoding, settings or Settings(), display, view)


def main_planes(image: Image, pixels: Array) -> dict[str, Array]:
    """Return the main image's channels, name -> (H, W): R, G, B[, A]; R = G = B of a mono or matte; else its own."""
    if image.type != "color" and pixel_type(image.type).shown:
        return dict.fromkeys(("R", "G", "B"), pixels[..., 0])
    return {name: pixels[..., index] for index, name in enumerate(image.channels)}


def layer_planes(name: str, image: Image, pixels: Array) -> dict[str, Array]:
    """Return a layer's channels, name -> (H, W).

    A channel is n.<last part of its name>: n.R ... of a color image, n.x and n.y of a flow, n.Z of a depth.
    """
    short = [channel.rpartition(".")[2] for channel in image.channels]
    if len(set(short)) < len(short):  # left.x and right.x would be one
        short = list(image.channels)
    return {f"{name}.{channel}": pixels[..., index] for index, channel in enumerate(short)}


def moved(plane: npt.NDArray[Any], source: Window, target: Window) -> npt.NDArray[Any]:
    """Return a plane, (H, W) of any data type, on the window ``target``: cut, and 0 where it has no pixels."""
    if source == target:
        return plane
    result = np.zeros((target.height, target.width), plane.dtype)
    x0, x1 = max(source.x, target.x), min(source.x + source.width, target.x + target.width)
    y0, y1 = max(source.y, target.y), min(source.y + source.height, target.y + target.height)
    if x0 < x1 and y0 < y1:
        inside = plane[y0 - source.y : y1 - source.y, x0 - source.x : x1 - source.x]
        result[y0 - target.y : y1 - target.y, x0 - target.x : x1 - target.x] = inside
    return result


def windows(spec: oiio.ImageSpec) -> tuple[Window, Window]:
    """Return data window and display window of a header."""
    data = Window(spec.x, spec.y, spec.width, spec.height)
    return data, Window(spec.full_x, spec.full_y, spec.full_width, spec.full_height)
