"""Read the passes of a render that are no colour: depth, normals, motion, ids."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import FlowabsError, ReadError
from flowabs_nodes.image import Image, Origin
from flowabs_nodes.io import cryptomatte, passes
from flowabs_nodes.io.image_file import PictureFile, open_picture
from flowabs_nodes.io.layers import Selection
from flowabs_nodes.io.passes import Layer, Names, Pick
from flowabs_nodes.io.read import Say, quiet, selected_spec
from flowabs_nodes.io.settings import Settings, checked
from flowabs_nodes.port_types import FAR, TYPES

#: A vector of Blender's that is as long as this, or longer, stands where there is no surface to move.
NO_MOTION = 3e5
_HALF_MAX = 65504.0  # what larger numbers become where they are stored as half


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

    ``layer`` "" finds the layer by the usual names (:data:`flowabs_nodes.io.passes.DEPTH`). The background becomes
    1e10, as Blender has it: whatever is 1e10 or more, Inf, and 65504, the largest half, in a half channel. ``note`` is
    told how many pixels these are, ``warn`` of NaN, which count as background too. Raises ReadError as
    :func:`~flowabs_nodes.io.read.read_image`, and where no layer, or more than one, could be meant.
    """
    with _opened(path, settings, part) as (file, layers):
        chosen = _chosen(file, layers, layer, passes.DEPTH, Layer.single, note)
        pixels = _grey(file.read(chosen.part, chosen.channels), chosen)
        half = _is_half(file, chosen)
        nans = int(np.isnan(pixels).sum())
        far = ~(pixels < (_HALF_MAX if half else FAR)) | np.isneginf(pixels)
        if nans:
            warn(f"{nans} NaN in the depth count as background")
        if far.any():
            note(f"{int(far.sum())} pixels are background: depth {FAR:g}")
            pixels = np.where(far, np.float32(FAR), pixels)
        return _image(file, chosen, "depth", pixels)


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

    ``layer`` "" finds the layer by the usual names (:data:`flowabs_nodes.io.passes.NORMAL`). A normal with NaN or Inf
    becomes 0, 0, 0, and ``warn`` is told how many there are. Raises ReadError as :func:`read_depth`.
    """
    with _opened(path, settings, part) as (file, layers):
        chosen = _chosen(file, layers, layer, passes.NORMAL, lambda each: each.vector(3), note)
        pixels = file.read(chosen.part, chosen.channels)
        whole = np.isfinite(pixels).all(axis=2, keepdims=True)
        broken = pixels.shape[0] * pixels.shape[1] - np.count_nonzero(whole)
        if broken:
            warn(f"{broken} normals with NaN or Inf become 0, 0, 0")
            pixels = np.where(whole, pixels, np.float32(0))
        return _image(file, chosen, "normal", pixels)


def read_motion(
    path: str | os.PathLike[str],
    *,
    layer: str = "",
    part: str | int = "",
    convention: str = "auto",
    settings: Settings | None = None,
    note: Say = quiet,
    warn: Say = quiet,
) -> Image:
    """Read a motion pass as a motion image: pixels, y up, in Blender's convention whatever the file's is.

    ``layer`` "" finds the layer by the usual names (:data:`flowabs_nodes.io.passes.MOTION`), or the two layers of
    RenderMan (motionBack, motionFore) and Nuke (backward, forward).

    Parameters
    ----------
    convention
        "blender": X, Y lead to the place on the previous frame, -Z, -W to that on the next; kept as they are. "forward"
        and "backward": the first two channels lead to the next or the previous frame; the other way is taken for the
        opposite. "auto" takes X, Y, Z, W for "blender", a layer motionBack or backward for "backward", others for
        "forward".

    Where Blender found no surface it writes vectors of 3e5 and more (65504 in a half channel): these, NaN and Inf
    become 0, and ``note`` is told how many. Raises ReadError as :func:`read_depth`.
    """
    with _opened(path, settings, part) as (file, layers):
        ways = _ways(file, layers, layer, convention)
        found: dict[str, Array] = {}
        for way, chosen in ways.items():
            if not layer:
                note(f"layer {chosen.layer!r} is read, as {way}")
            found[way] = _moving(file.read(chosen.part, chosen.channels), _is_half(file, chosen), note)
        if "blender" in found:
            pixels = found["blender"]
        else:
            forward, backward = found.get("forward"), found.get("backward")
            previous = backward if backward is not None else 0 - _known(forward)
            following = 0 - forward if forward is not None else _known(backward)
            pixels = np.concatenate([previous, following], axis=2)
        return _image(file, next(iter(ways.values())), "motion", pixels)


def read_id(
    path: str | os.PathLike[str],
    *,
    layer: str = "",
    part: str | int = "",
    settings: Settings | None = None,
    note: Say = quiet,
    warn: Say = quiet,
) -> tuple[Image, Image]:
    """Read an id pass: an id image, uint32, and as a mono the part of each pixel that its id covers, 0 to 1.

    ``layer`` "" takes the Cryptomatte of objects, else a channel of whole numbers, by the usual names
    (:data:`flowabs_nodes.io.passes.CRYPTOMATTE` and ``ID``), else the file's only Cryptomatte. Of a Cryptomatte the id
    that covers most of a pixel is taken, 0 where the background does; its manifest goes along as metadata. Whole
    numbers may be stored as uint, float or half; their coverage is 1, and -1 becomes 4294967295. Raises ReadError as
    :func:`read_depth`, and where a channel's numbers are not whole.
    """
    with _opened(path, settings, part) as (file, layers):
        known = cryptomatte.declared(file.specs)
        chosen = _id_layer(file, layers, layer, known)
        if not layer:
            note(f"layer {chosen.layer!r} is read")
        if len(chosen.channels) == 4:
            ids, coverage = cryptomatte.majority(file, layers, chosen)
        else:
            planes = file.read_native(chosen.part, chosen.channels)
            ids = _whole(_grey(np.stack([planes[name] for name in chosen.channels], axis=2), chosen))[..., 0]
            coverage = np.ones(ids.shape, np.float32)
        manifest = known.get(cryptomatte.base_name(chosen.layer), {}) if len(chosen.channels) == 4 else {}
        return _image(file, chosen, "id", ids, manifest), _image(file, chosen, "mono", coverage, manifest)


# ---------------------------------------------------------------------- which layer


def _chosen(file: PictureFile, layers: Sequence[Layer], layer: str, names: Names, pick: Pick, note: Say) -> Selection:
    """Return the channels of the layer that is asked for, or of the one with a usual name. Raises ReadError."""
    if layer:
        return passes.find_named(file.specs, layers, layer, names, pick)
    chosen = passes.find_usual(file.specs, layers, names, pick)
    if chosen is None:
        raise passes.missing(file.specs, layers, names)
    note(f"layer {chosen.layer!r} is read")
    return chosen


def _ways(file: PictureFile, layers: Sequence[Layer], layer: str, convention: str) -> dict[str, Selection]:
    """Return the layers of a motion by their convention: one of "blender", or one or both of the others."""

    def pick(each: Layer) -> tuple[str, ...] | None:
        four = convention == "blender" or (convention == "auto" and bool({"W", "w"} & set(each.channels)))
        return each.vector(4 if four else 2)

    def way(chosen: Selection) -> str:
        if convention != "auto":
            return convention
        back = passes.plain_name(chosen.layer) in passes.MOTION_BACKWARD.usual
        return "blender" if len(chosen.channels) == 4 else "backward" if back else "forward"

    if layer:
        chosen = passes.find_named(file.specs, layers, layer, passes.MOTION, pick)
        return {way(chosen): chosen}
    both = passes.find_usual(file.specs, layers, passes.MOTION, pick)
    if both:
        return {way(both): both}
    single = {
        name: found
        for name, names in (("backward", passes.MOTION_BACKWARD), ("forward", passes.MOTION_FORWARD))
        if convention in ("auto", name) and (found := passes.find_usual(file.specs, layers, names, pick))
    }
    if not single:
        usual = (*passes.MOTION.usual, *passes.MOTION_FORWARD.usual, *passes.MOTION_BACKWARD.usual)
        raise passes.missing(file.specs, layers, passes.MOTION._replace(usual=usual))
    return single


def _id_layer(file: PictureFile, layers: Sequence[Layer], layer: str, known: dict[str, dict[str, Any]]) -> Selection:
    """Return four channels of a Cryptomatte's first level, or the channel of whole numbers, to read ids from."""
    bases = set(known) | {
        cryptomatte.base_name(each.name)
        for each in layers
        if passes.plain_name(each.name).startswith("crypto") and cryptomatte.first_level(each)
    }
    levels = [each for each in layers if cryptomatte.base_name(each.name) in bases and cryptomatte.first_level(each)]
    if layer:
        wanted = cryptomatte.base_name(layer)
        if any(wanted in (base, base.rpartition(".")[2]) for base in bases):
            names = passes.CRYPTOMATTE
            return passes.find_named(file.specs, levels, wanted + "00", names, cryptomatte.first_level)
        return passes.find_named(file.specs, layers, layer, passes.ID, Layer.single)
    found = passes.find_usual(file.specs, levels, passes.CRYPTOMATTE, cryptomatte.first_level)
    found = found or passes.find_usual(file.specs, layers, passes.ID, Layer.single)
    if found is None and len(levels) == 1:
        found = Selection(levels[0].part, levels[0].name, cryptomatte.first_level(levels[0]) or ())
    if found is None:
        usual = (*passes.CRYPTOMATTE.usual, *passes.ID.usual)
        raise passes.missing(file.specs, layers, passes.ID._replace(usual=usual))
    return found


# ---------------------------------------------------------------------- numbers


def _grey(pixels: npt.NDArray[Any], chosen: Selection) -> npt.NDArray[Any]:
    """Return the first channel, (H, W, 1). Raises ReadError where others are not the same: then it is a colour."""
    if not (pixels[..., 1:] == pixels[..., :1]).all():
        names = ", ".join(chosen.channels)
        raise ReadError(
            f"layer {chosen.layer!r} is no single number: {names} differ", code="wrong-layer", parameter="layer"
        )
    return pixels[..., :1]


def _moving(pixels: Array, half: bool, note: Say) -> Array:
    """Return vectors, pairs of channels of (H, W, 2 or 4), with 0, 0 in place of those that stand for no surface."""
    pairs = pixels.reshape(*pixels.shape[:2], -1, 2)
    with np.errstate(invalid="ignore"):
        known = np.asarray((np.abs(pairs) < (_HALF_MAX if half else NO_MOTION)).all(axis=3, keepdims=True))
    still = np.count_nonzero(~known[..., 0].all(axis=2))
    if not still:
        return pixels
    note(f"{still} pixels have no surface that could move: their motion is 0")
    return np.where(known, pairs, np.float32(0)).reshape(pixels.shape)


def _known(pixels: Array | None) -> Array:
    """Return the vectors of the one way that a file has."""
    assert pixels is not None
    return pixels


def _whole(numbers: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return ids, uint32, of numbers of any type; -1 becomes 4294967295. Raises ReadError where some are not whole."""
    if numbers.dtype.kind == "f":
        numbers = numbers.astype(np.float64)
    with np.errstate(invalid="ignore"):
        wrong = int((numbers != np.floor(numbers)).sum()) + int((np.abs(numbers) > 2**32 - 1).sum())
        if wrong:
            raise ReadError(
                f"{wrong} of the numbers are no ids: whole, and at most 4294967295",
                code="wrong-layer",
                hint="read_aov reads any numbers",
                parameter="layer",
            )
    if numbers.dtype.kind == "f" and (numbers < 0).any():
        numbers = numbers.astype(np.int64) & 0xFFFFFFFF
    return TYPES["id"].cast(numbers, whole_floats=True)


# ---------------------------------------------------------------------- files


@contextmanager
def _opened(
    path: str | os.PathLike[str], settings: Settings | None, part: str | int
) -> Iterator[tuple[PictureFile, list[Layer]]]:
    """Open a file and give it with its layers; errors inside say which file."""
    settings = settings or Settings()
    name = os.fspath(checked(path, settings))
    try:
        with open_picture(name, settings) as file:
            yield file, passes.layers_of(file.specs, part)
    except FlowabsError as error:
        error.at(file=name)
        raise


def _is_half(file: PictureFile, chosen: Selection) -> bool:
    """Return True if the chosen channels are stored as half."""
    spec = file.specs[chosen.part]
    return bool(spec.channelformat(spec.channelnames.index(chosen.channels[0])) == oiio.TypeHalf)


def _image(
    file: PictureFile, chosen: Selection, type: str, pixels: npt.NDArray[Any], metadata: dict[str, Any] | None = None
) -> Image:
    """Return an image of pixels (H, W) or (H, W, C), with the header of the part that they were read from."""
    spec = selected_spec(file.specs[chosen.part], chosen, TYPES[type].typical_channels)
    for name, value in (metadata or {}).items():
        spec.attribute(name, value)
    origin = Origin(os.path.abspath(file.path), chosen.part, chosen.layer, chosen.channels)
    return Image(pixels if pixels.ndim == 3 else pixels[..., None], spec, type, origin=origin)
