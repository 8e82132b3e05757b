"""Pass the plate's other layers through, bit for bit (``write.keep_layers``), and an alpha that the image left out."""

from __future__ import annotations

import fnmatch
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes.errors import FlowabsError, WriteError, nearest
from flowabs_nodes.image import Image, Origin
from flowabs_nodes.image.header_text import readable
from flowabs_nodes.io import formats
from flowabs_nodes.io.exr_header import header_of_part
from flowabs_nodes.io.image_file import PictureFile, open_picture
from flowabs_nodes.io.layers import layer_of, part_name
from flowabs_nodes.io.orientation import upright
from flowabs_nodes.io.output_image import Picture, moved, windows
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.io.views import read_view, renamed, views_of

Planes = dict[str, npt.NDArray[Any]]


class Passthrough(NamedTuple):
    """What is written as it was in the plate: channels of the main part, and further parts as (header, channels)."""

    channels: Planes
    parts: tuple[tuple[dict[str, Any], Planes], ...] = ()


def passthrough_layers(picture: Picture, warn: Callable[[str], None]) -> Passthrough:
    """Read what ``keep_layers`` asks for from the file that the image was read from.

    A layer is a name before the last dot ("diffuse"), a channel without one ("Z"), or a part; ``*`` and ``?`` stand for
    letters. The layer that was read is kept only if it is named. ``warn`` is told of layers that are left out or cut.
    Raises WriteError for a name that is not there, ReadError where the file cannot be read any more.
    """
    wanted = [name.strip() for name in picture.keep_layers.split(",") if name.strip()]
    origin = picture.image.origin
    if not wanted:
        return Passthrough({})
    if origin is None or picture.plate_format is None or not picture.plate_format.layers:
        warn("keep_layers: the image does not come from an EXR file, so there are no other layers to keep")
        return Passthrough({})
    with open_picture(origin.file, picture.settings) as file:
        data, display = windows(file.specs[origin.part])
        if display != picture.image.display_window:
            warn("keep_layers: the picture has another size than the plate; its other layers are left out")
            return Passthrough({})
        chosen = _chosen(file, origin, wanted, set(picture.layers))
        mine = file.read_native(origin.part, chosen.pop(origin.part, []))
        views = views_of(file.specs[origin.part])
        mine = {renamed(name, views, read_view(origin, views)): plane for name, plane in mine.items()}
        if mine and data != picture.image.data_window:
            warn("keep_layers: the picture has another data window than the plate; its other layers are cut to it")
            mine = {name: moved(plane, data, picture.image.data_window) for name, plane in mine.items()}
        parts = []
        for part, channels in chosen.items():
            header = header_of_part(file.place, part, warn)
            header["compression"] = file.specs[part].get_string_attribute("compression")
            parts.append((header, _named(file.read_native(part, channels))))
    return Passthrough(_named(mine), tuple(parts))


def _named(planes: Planes) -> Planes:
    """Return channels under names that can be written: one that is no UTF-8 is taken for Latin-1."""
    return {readable(name.encode("utf-8", "surrogateescape")): plane for name, plane in planes.items()}


def layers_left_out(image: Image, layers: Mapping[str, Image], settings: Settings) -> tuple[str, ...]:
    """Return the names of the plate's layers that ``keep_layers`` "*" would keep, but that are in none of the images.

    ``image`` and ``layers`` are what is written. An image that was read from the plate counts as the channels that it
    was read from. There are none where the file is not there any more, of deep data, and where the picture has another
    size than the plate: these cannot be kept.
    """
    origin = image.origin
    format = formats.by_extension(origin.file) if origin is not None else None
    if origin is None or format is None or not format.layers:
        return ()
    with suppress(FlowabsError), open_picture(origin.file, settings) as file:
        if windows(file.specs[origin.part])[1] != image.display_window:
            return ()
        chosen = _chosen(file, origin, ["*"], set(layers))
        origins = [each.origin for each in layers.values() if each.origin is not None]
        written = {(each.file, each.part, channel) for each in origins for channel in each.channels}
        return tuple(
            dict.fromkeys(
                layer_of(channel) or part_name(file.specs[part])
                for part, channels in chosen.items()
                for channel in channels
                if (origin.file, part, channel) not in written
            )
        )
    return ()


def alpha_left_out(picture: Picture, warn: Callable[[str], None]) -> Planes:
    """Read the A that the image does not have but its plate does, so that it is not lost; {} where there is none.

    The plane is on the image's data window, upright like the image, and in the file's own type of float; whole numbers
    become 0..1, 8 bits as half and more as float, which both hold exactly.
    """
    image, origin = picture.image, picture.image.origin
    if origin is None or not origin.alpha or image.type != "color" or "A" in image.channels:
        return {}
    with open_picture(origin.file, picture.settings) as file:
        spec = oiio.ImageSpec(file.specs[origin.part])
        plane = file.read_native(origin.part, [origin.alpha])[origin.alpha]
        if file.format.integers == "normalized":
            plane = _as_float(plane)
        if file.format.oriented:
            plane = np.ascontiguousarray(upright(plane[..., None], spec)[..., 0])
    data, display = windows(spec)
    window = image.data_window
    if not plane.any():
        return {"A": np.zeros((window.height, window.width), plane.dtype)}
    if display != image.display_window:
        warn("alpha: the picture has another size than the plate; the alpha that was ignored is left out")
        return {}
    return {"A": moved(plane, data, window)}


def _as_float(plane: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return a plane of a photograph as EXR can hold it: half and float stay, whole numbers become 0..1."""
    if plane.dtype.kind in "ui":
        scaled = plane / np.float64(np.iinfo(plane.dtype).max)
        return scaled.astype(np.float16 if plane.dtype.itemsize == 1 else np.float32)
    return plane if plane.dtype in (np.float16, np.float32) else plane.astype(np.float32)


def _chosen(file: PictureFile, origin: Origin, wanted: list[str], new: set[str]) -> dict[int, list[str]]:
    """Return the channels to keep, by part. ``new`` are layers of the frame itself, which replace the plate's."""
    known: set[str] = set()
    matched: set[str] = set()
    chosen: dict[int, list[str]] = {}
    for part, spec in enumerate(file.specs):
        own = part == origin.part
        whole = "" if own else part_name(spec)
        views = views_of(spec) if own else ()
        # Where another view than the default is read, the plain R, G, B are a layer, the default view's.
        aside = bool(views) and read_view(origin, views) != views[0]
        for channel in spec.channelnames:
            layer = layer_of(channel)
            names = {name for name in (layer, whole) if name}
            if aside and "." not in channel:
                names |= {views[0]}
            known |= names
            hits = {pattern for pattern in wanted for name in names if fnmatch.fnmatchcase(name, pattern)}
            matched |= hits
            named = bool(hits & names)
            replaced = bool(names & new) or (
                own and ((layer == "" and not aside) or (channel in origin.channels and not (named and not aside)))
            )
            if hits and not replaced:
                if spec.deep:
                    raise WriteError(
                        f"part {whole or part} is deep data, which cannot be kept", parameter="keep_layers"
                    )
                chosen.setdefault(part, []).append(channel)
    missing = [pattern for pattern in wanted if pattern not in matched and pattern != "*"]
    if missing:
        found = ", ".join(sorted(known)[:20]) or "none"
        raise WriteError(
            f"keep_layers: the plate has no layer {missing[0]!r}; it has {found}",
            code="no-layer",
            hint=nearest(missing[0], known),
            parameter="keep_layers",
            file=origin.file,
        )
    return chosen
