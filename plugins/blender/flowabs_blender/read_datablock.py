"""Makes a flowabs image of one of Blender's: of its file where that says more, else of the pixels that Blender holds.

Colour space and alpha are what the Image Editor says of the picture, whatever the file says. A file's data window and
header are kept; Blender knows neither.
"""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np

from flowabs_nodes import Image
from flowabs_nodes.array_types import Array
from flowabs_nodes.color import ocio
from flowabs_nodes.errors import FlowabsError, ReadError
from flowabs_nodes.io import alpha as alphas
from flowabs_nodes.io import formats, nonfinite
from flowabs_nodes.io.read import quiet, read_image

from .color_names import settings_for, working_space

Say = Callable[[str], None]

#: Pictures of which Blender gives no pixels, and what to do about it.
_UNREADABLE = {
    "RENDER_RESULT": ("a render result, whose pixels Blender gives to nobody", "save it as an OpenEXR file"),
    "MOVIE": ("a movie", "render it as a sequence of OpenEXR files"),
    "TILED": ("a picture of several tiles (UDIM)", "run the graph on the file of one tile"),
}

#: What Blender says of an alpha that is none.
_OPAQUE = ("NONE", "CHANNEL_PACKED")


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
    for kind in (datablock.type, datablock.source):
        if kind in _UNREADABLE:
            what, hint = _UNREADABLE[kind]
            raise ReadError(f"{named(datablock)} is {what}", code="no-pixels", hint=hint)
    try:
        file = file_of(datablock, frame=frame, user=user)
        if file is not None:
            return _read(datablock, file, layer, note, warn)
        pixels = _pixels(datablock)
        if pixels is not None:
            return _of_pixels(datablock, pixels, note)
        if datablock.packed_file is not None:  # several layers, of which Blender shows none without an editor
            return _unpacked(datablock, layer, note, warn)
        path = path_of(datablock, frame=frame, user=user)
        if path is not None and not path.exists():
            raise ReadError("no such file", code="missing-file", file=str(path))
        raise ReadError("there are no pixels", code="no-pixels", file=str(path) if path is not None else None)
    except FlowabsError as error:
        error.message = f"{named(datablock)}: {error.message}"
        raise


def named(datablock: bpy.types.Image) -> str:
    """Return what messages call a datablock."""
    return f"image {datablock.name!r}"


def file_of(
    datablock: bpy.types.Image, *, frame: int | None = None, user: bpy.types.ImageUser | None = None
) -> Path | None:
    """Return the file that holds just what a datablock shows, of a format that flowabs reads; None where none does.

    None also of a picture that is packed into the .blend, or that was painted on since it was loaded.
    """
    path = path_of(datablock, frame=frame, user=user)
    if path is None or datablock.packed_file is not None or datablock.is_dirty:
        return None
    return path if path.is_file() and formats.by_extension(path) is not None else None


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


def _read(datablock: bpy.types.Image, file: Path, layer: str, note: Say, warn: Say) -> Image:
    """Return the picture of a file, of the colours that Blender shows it in."""
    space = datablock.colorspace_settings.name
    if space == "scene_linear":
        space = working_space().name
    return read_image(
        file,
        layer=layer,
        colorspace=space,
        alpha=_alpha(datablock, file),
        settings=settings_for(space),
        note=note,
        warn=warn,
    )


def _alpha(datablock: bpy.types.Image, file: Path) -> str:
    """Return what alpha means, as ``read_image`` takes it: "auto" where Blender says what is usual in such a file."""
    format = formats.by_extension(file)
    usual = "STRAIGHT" if format is not None and format.display_referred else "PREMUL"
    said = datablock.alpha_mode
    if said in _OPAQUE:
        return "ignore"
    return "auto" if said == usual else {"STRAIGHT": "straight", "PREMUL": "premultiplied"}[said]


def _unpacked(datablock: bpy.types.Image, layer: str, note: Say, warn: Say) -> Image:
    """Return the picture of a file that is packed into the .blend."""
    content = datablock.packed_file.data
    format = formats.by_content(content[:16])
    if format is None:
        raise ReadError("the packed file is of no format that is read here", code="bad-format")
    with tempfile.TemporaryDirectory(prefix="flowabs-") as folder:
        file = Path(folder) / f"packed{format.extensions[0]}"
        file.write_bytes(content)
        return _read(datablock, file, layer, note, warn)


def _pixels(datablock: bpy.types.Image) -> Array | None:
    """Return the pixels as Blender holds them, (H, W, C) float32, the lowest row first; None where it holds none."""
    count = len(datablock.pixels)  # loads the file
    width, height = datablock.size
    if not count or not width or not height:
        return None
    pixels = np.empty(count, np.float32)
    datablock.pixels.foreach_get(pixels)
    return pixels.reshape(height, width, -1)


def _of_pixels(datablock: bpy.types.Image, pixels: Array, note: Say) -> Image:
    """Return an image of pixels: scene-linear and premultiplied in a float picture, else codes under straight alpha."""
    pixels, repairs = nonfinite.repaired(np.ascontiguousarray(pixels[::-1]), "repair")
    if repairs:
        note(repairs)
    alpha = pixels[..., -1] if pixels.shape[2] in (2, 4) and datablock.alpha_mode not in _OPAQUE else None
    if alpha is not None and (not alpha.any() or (alpha == 1).all()):
        alpha = None
    rgb = pixels[..., :3] if pixels.shape[2] > 2 else np.repeat(pixels[..., :1], 3, axis=2)
    said = datablock.colorspace_settings
    if datablock.is_float or said.is_data:
        space = working_space()
    else:
        rgb, space = ocio.linearize(rgb, said.name, settings_for(said.name).ocio)
    if alpha is not None:
        rgb = rgb if datablock.is_float else alphas.premultiplied(rgb, alpha)
        rgb = np.concatenate([rgb, alpha[..., None]], axis=2)
    return Image.from_array(rgb, space)
