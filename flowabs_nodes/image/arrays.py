"""Convert a host's arrays and flat buffers to the parts of an image, and an image's pixels to a host's.

The functions here know nothing of :class:`~flowabs_nodes.image.Image`, whose methods call them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes.color import ColorSpace
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.image import light
from flowabs_nodes.image.buffer import data_type, picture_in
from flowabs_nodes.image.channels import Channels, layout, picks
from flowabs_nodes.image.numbers import Numbers, meaning
from flowabs_nodes.image.parts import Parts, Window, with_channels
from flowabs_nodes.port_types import PortType, pixel_type


class Memory(NamedTuple):
    """The memory of a host's picture: the arguments of :func:`~flowabs_nodes.image.buffer.picture_in`."""

    memory: Any
    shape: Sequence[int] | None
    row_bytes: int | None
    dtype: npt.DTypeLike | None
    rows: str


class Said(NamedTuple):
    """What somebody says of the numbers: the arguments of :func:`~flowabs_nodes.image.numbers.meaning`."""

    colorspace: ColorSpace | str | None
    encoding: str | None
    alpha: str | None


# ---------------------------------------------------------------------- from a host


def parts_of_array(
    source: Memory, type: PortType | None, channels: Channels | None, said: Said, windows: Sequence[Any]
) -> tuple[Parts, ColorSpace]:
    """Return the parts of an image of a host's picture, which is copied, and the scene-linear space that it is in.

    ``type`` and ``channels`` are those of :func:`~flowabs_nodes.image.channels.layout`; ``windows`` are the data window
    and the display window, each four numbers or None. ArgumentError for what does not fit; for uint8 and uint16
    pictures that are said to be linear, and for other whole numbers under an encoding. ColorError for a name that is no
    colour space.
    """
    picture = picture_in(*source, "array")
    type, names, order = layout(picture.shape[2], type, channels)
    if order != tuple(range(picture.shape[2])):
        picture = picture[..., list(order)]
    pixels, space = _pixels(picture, type, said)
    return Parts(pixels, _header(pixels, names, *windows), type), space


def _pixels(picture: npt.NDArray[Any], type: PortType, said: Said) -> tuple[npt.NDArray[Any], ColorSpace]:
    """Return the pixels of an image of numbers (H, W, C), a copy, and their scene-linear space."""
    declared, stored = pixel_type(type), picture.dtype
    numbers = meaning(*said, floats=stored.kind == "f")
    if not declared.shown:
        pixels = declared.cast(picture, whole_floats=True)
        return pixels.copy() if np.may_share_memory(picture, pixels) else pixels, numbers.kept
    if not declared.light:
        numbers = replace(numbers, encoding=None, straight=False, kept=numbers.space)
    if numbers.scaled:
        if stored.kind != "f" and not _has_white(stored):
            name = said.colorspace if said.encoding is None else said.encoding
            raise ArgumentError(f"array: expected uint8, uint16 or floats of {name}, found {stored}", parameter="array")
        return light.decoded(picture, numbers), numbers.kept
    if _has_white(stored):
        white = np.iinfo(stored).max
        raise ArgumentError(
            f"array: expected {type} with white at 1, found {stored} with white at {white}",
            hint=f"divide by {white}"
            + (', or colorspace="sRGB" for a picture as screens show it' if declared.light else ""),
            parameter="array",
        )
    if type != "mono" and stored.kind in "iu" and picture.max() > 8:  # no light
        raise ArgumentError(
            f"array: expected {type} with white at 1, found {stored} up to {picture.max():g}",
            hint='as uint8 or uint16, with colorspace="sRGB", it is decoded'
            if type == "color"
            else "divide by its white",
            parameter="array",
        )
    return light.decoded(picture, numbers), numbers.kept


def _has_white(dtype: np.dtype[Any]) -> bool:
    """Return whether a data type is one of whole numbers whose largest is white: 8 or 16 bits, in any byte order."""
    return dtype.kind == "u" and dtype.itemsize <= 2


def _header(
    pixels: npt.NDArray[Any],
    names: tuple[str, ...],
    data_window: Sequence[int] | None,
    display_window: Sequence[int] | None,
) -> oiio.ImageSpec:
    """Return a header for pixels (H, W, C). Raises ArgumentError for windows that are none, or do not fit."""
    height, width, count = pixels.shape
    spec = oiio.ImageSpec(width, height, count, "float" if pixels.dtype.kind == "f" else "uint")
    data = Window(0, 0, width, height) if data_window is None else _window(data_window, "data_window")
    if data[2:] != (width, height):
        raise ArgumentError(
            f"data_window: expected one of {width}x{height}, as the array is, found {data.width}x{data.height}",
            parameter="data_window",
        )
    spec.x, spec.y = data.x, data.y
    display = data if display_window is None else _window(display_window, "display_window")
    spec.full_x, spec.full_y, spec.full_width, spec.full_height = display
    return with_channels(spec, names)


def _window(numbers: Sequence[int], name: str) -> Window:
    """Return four numbers as a window; raise ArgumentError for others."""
    try:
        window = Window(*(int(number) for number in numbers))
        whole = all(number == given for number, given in zip(window, numbers, strict=True))
    except (TypeError, ValueError):
        whole = False
    if not whole or window.width < 1 or window.height < 1:
        raise ArgumentError(
            f"{name}: expected four whole numbers (x, y, width, height), found {numbers!r}", parameter=name
        )
    return window


# ---------------------------------------------------------------------- to a host


class Shown(NamedTuple):
    """What of an image a host is given: its pixels (H, W, C), their names, type and scene-linear space."""

    pixels: npt.NDArray[Any]
    names: tuple[str, ...]
    type: PortType
    space: ColorSpace


def array_of(
    image: Shown, said: Said, rows: str, dtype: npt.DTypeLike | None, channels: Channels | None
) -> npt.NDArray[Any]:
    """Return an image's pixels as a host's array; a read-only view of them where nothing has to be converted."""
    declared = pixel_type(image.type)
    wanted = declared.dtype if dtype is None else data_type(dtype)
    chosen = picks(declared, image.names, channels)
    numbers = _for_host(image, said, wanted)
    first = chosen[0]
    as_it_is = wanted == image.pixels.dtype and (numbers is None or _means_the_pixels(numbers, image))
    if as_it_is and first is not None and chosen == tuple(range(first, first + len(chosen))):
        view = picture_in(image.pixels[..., first : first + len(chosen)], None, None, None, rows, "rows")
        view.flags.writeable = False
        return view
    out = np.empty((*image.pixels.shape[:2], len(chosen)), wanted)
    _write(picture_in(out, None, None, None, rows, "rows"), image, chosen, numbers)
    return out


def _means_the_pixels(numbers: Numbers, image: Shown) -> bool:
    """Return whether an image's pixels are just these numbers: light of their space, under an alpha as they say."""
    straight = numbers.straight and "A" in image.names
    return numbers.encoding is None and numbers.space == image.space and not straight


def fill(target: Memory, image: Shown, said: Said, channels: Channels | None) -> None:
    """Write an image's pixels into a host's memory, an array of their shape or a flat buffer.

    ArgumentError for memory that cannot be written to, and of another shape or length.
    """
    chosen = picks(pixel_type(image.type), image.names, channels)
    shape = (*image.pixels.shape[:2], len(chosen))
    try:
        memory = target.memory if hasattr(target.memory, "__array__") else memoryview(target.memory)
    except TypeError as error:
        found = type(target.memory).__name__
        message = f"out: expected an array or a buffer that can be written to, found {found}"
        raise ArgumentError(message, code="wrong-type", parameter="out") from error
    memory = np.asarray(memory)
    flat = memory.ndim not in (2, 3)
    picture = picture_in(*target._replace(memory=memory, shape=shape if flat else None), "out")
    if picture.shape != shape:
        names = "" if channels is not None or picture.shape[:2] != shape[:2] else "channels says which, such as 'RGBA'"
        raise ArgumentError(f"out: expected shape {shape}, found {memory.shape}", hint=names, parameter="out")
    if not picture.flags.writeable:
        raise ArgumentError("out: expected memory that can be written to, found read-only", parameter="out")
    _write(picture, image, chosen, _for_host(image, said, picture.dtype))


def _for_host(image: Shown, said: Said, dtype: np.dtype[Any]) -> Numbers | None:
    """Return what a host's numbers are to mean; None for a type that is no picture to look at.

    ArgumentError for whole numbers of colours whose encoding nobody says, and for types of whole numbers without white.
    """
    numbers = meaning(*said, floats=dtype.kind == "f", default=image.space)
    if not pixel_type(image.type).shown:
        return None
    if dtype.kind != "f" and not _has_white(dtype):
        raise ArgumentError(
            f"dtype: expected uint8, uint16 or floats for a {image.type}, found {dtype}", parameter="dtype"
        )
    if not pixel_type(image.type).light:
        return replace(numbers, space=image.space, encoding=None, straight=False)
    if dtype.kind != "f" and not numbers.scaled:
        raise ArgumentError(
            f"encoding: expected a name, such as 'sRGB', for {dtype} of scene-linear light, found none",
            hint='encoding="linear" writes light itself, 1 as white',
            parameter="encoding",
        )
    return numbers


def _write(
    target: npt.NDArray[Any],
    image: Shown,
    chosen: tuple[int | None, ...],
    numbers: Numbers | None,
) -> None:
    """Write an image's channels into a picture (H, W, C); ArgumentError where an id or data does not fit exactly."""
    if numbers is not None:
        light.encode_to(target, chosen, image.pixels, image.space, numbers)
        return
    values = image.pixels[..., [pick for pick in chosen if pick is not None]]
    if "f" == image.pixels.dtype.kind == target.dtype.kind:
        light.write(target, tuple(range(values.shape[2])), values)
        return
    with np.errstate(all="ignore"):
        whole = values.astype(target.dtype)
        fits = whole.astype(np.float64) == values
    if not fits.all():
        y, x, channel = np.argwhere(~fits)[0]
        raise ArgumentError(
            f"dtype: expected one that holds every {image.type}, found {target.dtype}, "
            f"which cannot hold {values[y, x, channel]:.10g} at x {x}, y {y}",
            parameter="dtype",
        )
    target[...] = whole
