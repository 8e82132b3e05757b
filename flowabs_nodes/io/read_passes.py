"""Read the depth and the normals of a render; and what reading any of its passes needs."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes.errors import FlowabsError, ReadError
from flowabs_nodes.filters.background import FAR
from flowabs_nodes.image import Image, Origin
from flowabs_nodes.io import passes
from flowabs_nodes.io.image_file import PictureFile, open_picture
from flowabs_nodes.io.layer_groups import Layer, Pick, layers_of
from flowabs_nodes.io.layers import Selection
from flowabs_nodes.io.pass_names import DEPTH, NORMAL, Names
from flowabs_nodes.io.read import Say, quiet, selected_spec
from flowabs_nodes.io.settings import Settings, checked
from flowabs_nodes.port_types import TYPES, PortType

#: The largest half: what any larger number may have become in a file.
HALF_MAX = 65504.0


def read_depth(
    path: str | os.PathLike[str],
    *,
    layer: str = "",
    part: str | int = "",
    settings: Settings | None = None,
    note: Say = quiet,
    warn: Say = quiet,
) -> Image:
    """Read a depth pass as a depth image: the numbers in the file, in scene units, always finite.

    ``layer`` "" finds the layer by the usual names (:data:`flowabs_nodes.io.pass_names.DEPTH`). The background becomes
    1e10, as Blender has it: whatever is 1e10 or more, Inf, and 65504, the largest half, in a half channel. ``note`` is
    told how many pixels these are, ``warn`` of NaN, which count as background too. Raises ReadError as
    :func:`~flowabs_nodes.io.read.read_image`, and where no layer, or more than one, could be meant.
    """
    with opened(path, settings, part) as (file, layers):
        chosen = chosen_layer(file, layers, layer, DEPTH, Layer.single)
        pixels = grey(file.read(chosen.part, chosen.channels), chosen, DEPTH)
        say_which(chosen, layer, note)
        half = is_half(file, chosen)
        nans = int(np.isnan(pixels).sum())
        far = ~(pixels < (HALF_MAX if half else FAR)) | np.isneginf(pixels)
        if nans:
            warn(f"{nans} NaN in the depth count as background")
        if far.any():
            note(f"{int(far.sum())} pixels are background: depth {FAR:g}")
            pixels = np.where(far, np.float32(FAR), pixels)
        return image_of(file, chosen, "depth", pixels)


def read_normal(
    path: str | os.PathLike[str],
    *,
    layer: str = "",
    part: str | int = "",
    settings: Settings | None = None,
    note: Say = quiet,
    warn: Say = quiet,
) -> Image:
    """Read a normal pass as a normal image: the numbers in the file, in the renderer's own space.

    ``layer`` "" finds the layer by the usual names (:data:`flowabs_nodes.io.pass_names.NORMAL`). A normal with NaN or
    Inf becomes 0, 0, 0, and ``warn`` is told how many there are. Raises ReadError as :func:`read_depth`.
    """
    with opened(path, settings, part) as (file, layers):
        chosen = chosen_layer(file, layers, layer, NORMAL, lambda each: each.vector(3))
        pixels = file.read(chosen.part, chosen.channels)
        if chosen.guessed:
            _check_lengths(pixels, chosen)
        say_which(chosen, layer, note)
        if not np.isfinite(pixels).all():
            whole = np.isfinite(pixels).all(axis=2, keepdims=True)
            broken = pixels.shape[0] * pixels.shape[1] - np.count_nonzero(whole)
            warn(f"{broken} normals with NaN or Inf become 0, 0, 0")
            pixels = np.where(whole, pixels, np.float32(0))
        return image_of(file, chosen, "normal", pixels)


def _check_lengths(pixels: npt.NDArray[Any], chosen: Selection) -> None:
    """Raise ReadError where most vectors are not of length 1: they are a picture, or normals stored as 0 to 1."""
    with np.errstate(invalid="ignore", over="ignore"):
        lengths = np.linalg.norm(pixels, axis=2)
    lengths = lengths[np.isfinite(lengths) & (lengths > 0)]
    share = (np.abs(lengths - 1) < 0.05).mean() if lengths.size else 1
    if share < 0.5:
        raise passes.guessed_wrong(chosen, NORMAL, f"{share:.0%} of the vectors have the length 1")


# ---------------------------------------------------------------------- for all passes


def read_nothing(
    path: str | os.PathLike[str], type: PortType, *, part: str | int = "", settings: Settings | None = None
) -> Image:
    """Return a pass of the size of a file's first part that shows nothing: 0, background depth.

    It stands for a pass that the file does not have. Raises ReadError as :func:`read_depth`.
    """
    with opened(path, settings, part) as (file, layers):
        spec = file.specs[layers[0].part]
        first = Selection(layers[0].part, "", (spec.channelnames[0],))
        channels = len(TYPES[type].typical_channels)
        value = FAR if type == "depth" else 0
        return image_of(file, first, type, np.full((spec.height, spec.width, channels), value, TYPES[type].dtype))


@contextmanager
def opened(
    path: str | os.PathLike[str], settings: Settings | None, part: str | int
) -> Iterator[tuple[PictureFile, list[Layer]]]:
    """Open a file and give it with its layers; errors inside say which file."""
    settings = settings or Settings()
    name = os.fspath(checked(path, settings))
    try:
        with open_picture(name, settings) as file:
            yield file, layers_of(file.specs, part)
    except FlowabsError as error:
        error.at(file=name)
        raise


def chosen_layer(file: PictureFile, layers: Sequence[Layer], layer: str, names: Names, pick: Pick) -> Selection:
    """Return the channels of the layer that is asked for, of the one with a usual name, or of a file's only one.

    Raises ReadError.
    """
    if layer:
        return passes.find_named(file.specs, layers, layer, names, pick)
    found = passes.find_usual(file.specs, layers, names, pick) or passes.find_only(layers, pick)
    if found is None:
        raise passes.missing(file.specs, layers, names)
    return found


def say_which(chosen: Selection, asked: str, note: Say, how: str = "") -> None:
    """Tell ``note`` which layer is read where it is not the one asked for, and which view of a stereo file."""
    if chosen.layer not in ("", asked) and not chosen.guessed:
        note(f"layer {chosen.layer!r} is read{how}")
    if chosen.note:
        note(f"{chosen.note}{how if chosen.guessed else ''}")


def is_half(file: PictureFile, chosen: Selection) -> bool:
    """Return True if the chosen channels are stored as half."""
    spec = file.specs[chosen.part]
    return bool(spec.channelformat(spec.channelnames.index(chosen.channels[0])) == oiio.TypeHalf)


def grey(pixels: npt.NDArray[Any], chosen: Selection, names: Names) -> npt.NDArray[Any]:
    """Return the first channel, (H, W, 1). Raises ReadError where others are not the same: then it is a colour."""
    if not (pixels[..., 1:] == pixels[..., :1]).all():
        if chosen.guessed:
            raise passes.guessed_wrong(chosen, names, "each pixel has several numbers", meant=False)
        message = f"layer {chosen.layer!r} is no single number: {', '.join(chosen.channels)} differ"
        raise ReadError(message, code="wrong-layer", parameter="layer")
    return pixels[..., :1]


def image_of(
    file: PictureFile, chosen: Selection, type: str, pixels: npt.NDArray[Any], metadata: dict[str, Any] | None = None
) -> Image:
    """Return an image of pixels (H, W) or (H, W, C), with the header of the part that they were read from."""
    spec = selected_spec(file.specs[chosen.part], chosen, TYPES[type].typical_channels)
    for name, value in (metadata or {}).items():
        spec.attribute(name, value)
    origin = Origin(os.path.abspath(file.path), chosen.part, chosen.layer, chosen.channels)
    return Image(pixels if pixels.ndim == 3 else pixels[..., None], spec, type, origin=origin)
