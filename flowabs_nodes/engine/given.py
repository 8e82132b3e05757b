"""Reads what a caller gives a graph in place of outputs: images, arrays or ImageBufs, of one frame or of several."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import OpenImageIO as oiio

from flowabs_nodes.array_types import HasArray
from flowabs_nodes.engine.frame_numbers import whole_number
from flowabs_nodes.engine.plan import Result, named_result
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.graph.model import Graph
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Port
from flowabs_nodes.port_types import TYPES

#: An image, or what one is made of: an array of scene-linear light, of a matte or of data, or an ImageBuf.
Picture = Image | HasArray | oiio.ImageBuf

_ROWS_AT_ONCE = 64

#: Images that stand in for outputs, by the output's name: of the frame to run, or by frame number.
Given = Mapping[str, Picture | Mapping[int, Picture]]


def given_images(graph: Graph, given: Given, frame: int) -> dict[Result, Image]:
    """Return the images by the result they stand in for, each as a type that the output may have.

    Raises
    ------
    CommandError
        A name is no output of the graph.
    ArgumentError
        Something given is no image of the output's type, or none is of ``frame``.
    """
    if not isinstance(given, Mapping):
        raise ArgumentError(
            f'given: expected a dict such as {{"plate": image}}, found {type(given).__name__}',
            code="wrong-type",
            parameter="given",
        )
    images: dict[Result, Image] = {}
    for name, what in given.items():
        result = named_result(graph, name, frame)
        if result in images:
            raise ArgumentError(f"given[{name!r}]: this output is given twice", parameter="given")
        port = graph.nodes[result.node].declaration.all_outputs[result.output]
        if not isinstance(what, Mapping):
            images[result] = _image(port, what, f"given[{name!r}]")
            continue
        frames = {_frame(name, number): picture for number, picture in what.items()}
        if frame not in frames:
            found = ", ".join(map(str, frames)) or "none"
            raise ArgumentError(
                f"given[{name!r}]: expected an Image of frame {frame}, the one to run, among its frames, found {found}",
                parameter="given",
            )
        for number, picture in frames.items():
            images[result._replace(frame=number)] = _image(port, picture, f"given[{name!r}][{number}]")
    return images


def _frame(name: str, number: object) -> int:
    """Return a key of ``given[name]`` as the frame number that it is; raise ArgumentError if it is none."""
    frame = whole_number(number)
    if frame is None:
        raise ArgumentError(
            f"given[{name!r}]: expected frame numbers, found {number!r}", code="wrong-type", parameter="given"
        )
    return frame


def _image(port: Port, picture: Picture, place: str) -> Image:
    """Return the image that stands in for an output, as a type that the output may have; ``place`` is for errors."""
    try:
        image = picture if isinstance(picture, Image) else _made(port, picture)
    except ArgumentError as error:
        message = error.message.removeprefix(f"{error.parameter}: ")
        hint = error.hint.replace('colorspace="sRGB"', 'Image.from_array(array, colorspace="sRGB")')
        raise ArgumentError(f"{place}: {message}", code=error.code, hint=hint, parameter="given") from error
    kind = image.type if port.same_as else port.takes(image.type)
    if kind is None:
        raise ArgumentError(
            f"{place}: expected {port.types.replace('|', ' or ')}, found {image.type}",
            code="wrong-type",
            parameter="given",
        )
    return image.as_type(kind)


def _made(port: Port, picture: Any) -> Image:
    """Return the image of an ImageBuf or of an array: of the output's type, if its channels are such."""
    if isinstance(picture, oiio.ImageBuf):
        return Image.from_imagebuf(picture)
    if not hasattr(picture, "__array__"):
        raise ArgumentError(
            f"expected an Image or an array, found {type(picture).__name__}",
            code="wrong-type",
            hint="Image.from_array and Image.from_imagebuf make one",
        )
    array = np.asarray(picture)
    declared = TYPES.get(port.types)
    channels = array.shape[2] if array.ndim == 3 else 1
    fits = declared is not None and (not declared.channels or declared.channel_names(channels) is not None)
    return Image.from_array(array, type=port.types if fits else None)


def same_image(one: Image, other: Image) -> bool:
    """Return whether two images are the same, bit for bit: pixels, windows, metadata, type and colour space."""
    if one is other:
        return True
    if one.type != other.type or one.colorspace != other.colorspace or one.deferred or other.deferred:
        return False
    if one.pixels.shape != other.pixels.shape or one.spec.to_xml() != other.spec.to_xml():
        return False
    rows = range(0, one.pixels.shape[0], _ROWS_AT_ONCE)  # most pictures that differ do so in the first rows
    return all(
        np.array_equal(
            one.pixels[y : y + _ROWS_AT_ONCE].view(np.uint32), other.pixels[y : y + _ROWS_AT_ONCE].view(np.uint32)
        )
        for y in rows
    )
