"""Read the motion of a render, in whichever convention its renderer has, as Blender has it."""

from __future__ import annotations

import os
from collections.abc import Sequence

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.image import Image
from flowabs_nodes.io import passes
from flowabs_nodes.io.image_file import PictureFile
from flowabs_nodes.io.layer_groups import Layer, inside_of
from flowabs_nodes.io.layers import Selection, check_windows
from flowabs_nodes.io.pass_names import MOTION, MOTION_BACKWARD, MOTION_FORWARD, plain_name
from flowabs_nodes.io.read import Say, quiet
from flowabs_nodes.io.read_passes import HALF_MAX, image_of, is_half, opened, say_which
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.io.views import split_view, views_in

#: A vector of Blender's that is as long as this, or longer, stands where there is no surface to move.
NO_MOTION = 3e5
#: X and Y, and Z and W, of Blender's where it rendered nothing: outside of a render region.
NOT_RENDERED = 1e4


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

    ``layer`` "" finds the layer by the usual names (:data:`flowabs_nodes.io.pass_names.MOTION`), or the two layers of
    RenderMan (motionBack, motionFore) and Nuke (backward, forward).

    Parameters
    ----------
    convention
        "blender": X, Y lead to the place on the previous frame, -Z, -W to that on the next; kept as they are. "forward"
        and "backward": the first two channels lead to the next or the previous frame; the other way is taken for the
        opposite. "auto" takes X, Y, Z, W for "blender", a layer motionBack or backward for "backward", others for
        "forward".

    Where Blender found no surface it writes vectors of 3e5 and more (65504 in a half channel), and outside of a render
    region 1e4 and 1e4: these, NaN and Inf become 0, and ``note`` is told how many. Raises ReadError as
    :func:`read_depth`.
    """
    with opened(path, settings, part) as (file, layers):
        ways = _ways(file, layers, layer, convention)
        found: dict[str, Array] = {}
        for way, chosen in ways.items():
            pixels = file.read(chosen.part, chosen.channels)
            if chosen.guessed and pixels.any() and not (pixels < 0).any():
                raise passes.guessed_wrong(chosen, MOTION, "nothing moves left or down")
            say_which(chosen, layer, note, f", as {way}")
            found[way] = _moving(pixels, is_half(file, chosen), note)
        if "blender" in found:
            pixels = found["blender"]
        else:
            check_windows(file.specs, tuple(ways.values()))
            previous = found["backward"] if "backward" in found else 0 - found["forward"]
            following = 0 - found["forward"] if "forward" in found else found["backward"]
            pixels = np.concatenate([previous, following], axis=2)
        return image_of(file, next(iter(ways.values())), "motion", pixels)


def _ways(file: PictureFile, layers: Sequence[Layer], layer: str, convention: str) -> dict[str, Selection]:
    """Return the layers of a motion by their convention: one of "blender", or one or both of the others."""

    def pick(each: Layer) -> tuple[str, ...] | None:
        four = convention == "blender" or (convention == "auto" and bool({"W", "w"} & set(each.channels)))
        return each.vector(4 if four else 2)

    def way(chosen: Selection) -> str:
        if convention != "auto":
            return convention
        base = split_view(chosen.layer, views_in(file.specs))[0]
        back = plain_name(base) in MOTION_BACKWARD.usual
        return "blender" if len(chosen.channels) == 4 else "backward" if back else "forward"

    def usual(layers: Sequence[Layer]) -> dict[str, Selection]:
        if both := passes.find_usual(file.specs, layers, MOTION, pick):
            return {way(both): both}
        return {
            name: found
            for name, names in (("backward", MOTION_BACKWARD), ("forward", MOTION_FORWARD))
            if convention in ("auto", name) and (found := passes.find_usual(file.specs, layers, names, pick))
        }

    if layer:
        if ways := usual(inside_of(file.specs, layers, layer, pick)):
            return ways
        chosen = passes.find_named(file.specs, layers, layer, MOTION, pick)
        return {way(chosen): chosen}
    ways = usual(layers)
    if not ways and (only := passes.find_only(layers, pick)):
        ways = {way(only): only}
    if not ways:
        names = (*MOTION.usual, *MOTION_FORWARD.usual, *MOTION_BACKWARD.usual)
        raise passes.missing(file.specs, layers, MOTION._replace(usual=names))
    return ways


def _moving(pixels: Array, half: bool, note: Say) -> Array:
    """Return vectors, pairs of channels of (H, W, 2 or 4), with 0, 0 in place of those that stand for no surface."""
    if np.abs(pixels).max(initial=0) < NOT_RENDERED:  # no NaN either
        return pixels
    pairs = pixels.reshape(*pixels.shape[:2], -1, 2)
    limit = HALF_MAX if half else NO_MOTION
    x, y = pairs[..., 0], pairs[..., 1]  # apart: a reduction along an axis of two takes many times as long
    with np.errstate(invalid="ignore"):
        known = (np.abs(x) < limit) & (np.abs(y) < limit) & ((x != NOT_RENDERED) | (y != NOT_RENDERED))
    still = known.shape[0] * known.shape[1] - np.count_nonzero(np.logical_and.reduce(np.moveaxis(known, 2, 0)))
    if not still:
        return pixels
    note(f"{still} pixels have no surface that could move: their motion is 0")
    return np.where(known[..., None], pairs, np.float32(0)).reshape(pixels.shape)
