"""Makes a flowabs image of one of Blender's: of its file where that says more, else of the pixels that Blender holds.

Colour space and alpha are what the Image Editor says of the picture, whatever the file says. A file's data window and
header are kept; Blender knows neither.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import bpy
import numpy as np

from flowabs_nodes import Image
from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ReadError
from flowabs_nodes.io import formats
from flowabs_nodes.io.read import quiet

from .color_names import settings_for, working_space
from .render_result import take_last_render
from .taken import Say, Taken, about, named

#: Pictures of which Blender gives no pixels, and what to do about it.
_UNREADABLE = {
    "MOVIE": ("a movie", "render it as a sequence of OpenEXR files"),
    "TILED": ("a picture of several tiles (UDIM)", "run the graph on the file of one tile"),
}


def image_of(
    datablock: bpy.types.Image,
    *,
    frame: int | None = None,
    user: bpy.types.ImageUser | None = None,
    layer: str = "",
    note: Say = quiet,
    warn: Say = quiet,
) -> Image:
    """Return an Image datablock as a colour image: scene-linear, premultiplied, finite; for the main thread alone.

    Parameters
    ----------
    frame
        Of a sequence: the number in the file's name; without it, what ``user`` shows, else the scene's frame.
    user
        How an editor or a node shows the picture.
    layer
        Of a file with several layers, as :func:`~flowabs_nodes.io.read.read_image` takes it.
    note, warn
        Functions that are told what was found, and what is wrong with it.

    Raises
    ------
    ReadError
        There are no pixels: no file, a damaged one, one without a picture, or a datablock that Blender keeps to itself.
    ColorError
        Neither flowabs nor Blender's config knows the picture's colour space.
    """
    return take(datablock, frame=frame, user=user).image(layer, note, warn)


def take(datablock: bpy.types.Image, *, frame: int | None = None, user: bpy.types.ImageUser | None = None) -> Taken:
    """Take from Blender what an image is made of, quickly: files are read later. For the main thread alone.

    Parameters and errors are those of :func:`image_of`.
    """
    if datablock.type == "RENDER_RESULT":
        return take_last_render(bpy.context.scene)
    for kind in (datablock.type, datablock.source):
        if kind in _UNREADABLE:
            what, hint = _UNREADABLE[kind]
            raise ReadError(f"{named(datablock.name)} is {what}", code="no-pixels", hint=hint)
    with about(datablock.name):
        path = path_of(datablock, frame=frame, user=user)
        file = path if holds_what_is_shown(datablock, path) else None
        pixels = _pixels(datablock) if file is None else None
        packed = datablock.packed_file
        if file is None and pixels is None and packed is None:  # of several packed layers Blender shows none by itself
            raise _nothing_there(path)
        said = datablock.colorspace_settings
        working = working_space()
        space = working.name if said.name == "scene_linear" else said.name
        return Taken(
            name=datablock.name,
            file=file,
            pixels=pixels,
            content=bytes(packed.data) if file is None and pixels is None else None,
            space=space,
            settings=settings_for(space),
            is_data=said.is_data,
            is_float=datablock.is_float,
            alpha_mode=datablock.alpha_mode,
            working=working,
        )


def _nothing_there(path: Path | None) -> ReadError:
    """Return the error of a datablock without pixels."""
    if path is None:
        return ReadError("there are no pixels", code="no-pixels")
    if not path.exists():
        return ReadError("no such file", code="missing-file", file=str(path))
    what = "Blender finds no pixels in it, and it is of no format that is read here"
    return ReadError(what, code="no-pixels", file=str(path))


def holds_what_is_shown(datablock: bpy.types.Image, path: Path | None) -> bool:
    """Return whether a file is there, of a format that flowabs reads, and holds just what its datablock shows.

    It does not where the picture is packed into the .blend, or was painted on since it was loaded.
    """
    if path is None or datablock.packed_file is not None or datablock.is_dirty:
        return False
    return path.is_file() and formats.by_extension(path) is not None


def path_of(
    datablock: bpy.types.Image, *, frame: int | None = None, user: bpy.types.ImageUser | None = None
) -> Path | None:
    """Return the path that a datablock names, of a sequence that of a frame; None where it names none."""
    if datablock.source not in ("FILE", "SEQUENCE") or not datablock.filepath:
        return None
    if datablock.source == "SEQUENCE" and frame is None and user is not None:
        return Path(bpy.path.abspath(datablock.filepath_from_user(image_user=user), library=datablock.library))
    path = Path(bpy.path.abspath(datablock.filepath, library=datablock.library))
    if datablock.source == "FILE":
        return path
    return path.with_name(_of_frame(path.name, bpy.context.scene.frame_current if frame is None else frame))


def _of_frame(name: str, frame: int) -> str:
    """Return the name of another frame's file, as Blender finds it: by the last digits before the extension."""
    stem, extension = os.path.splitext(name)
    return re.sub(r"\d+(?=\D*$)", lambda digits: f"{frame:0{len(digits[0])}d}", stem) + extension


def _pixels(datablock: bpy.types.Image) -> Array | None:
    """Return the pixels as Blender holds them, (H, W, C) float32, the lowest row first; None where it holds none."""
    count = len(datablock.pixels)  # loads the file
    width, height = datablock.size
    if not count or not width or not height:
        return None
    pixels = np.empty(count, np.float32)
    datablock.pixels.foreach_get(pixels)
    return pixels.reshape(height, width, -1)
