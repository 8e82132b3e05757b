"""Makes a flowabs image of one of Blender's: of its file where that says more, else of the pixels that Blender holds.

Colour space and alpha are what the Image Editor says of the picture, whatever the file says. A file's data window and
header are kept; Blender knows neither.
"""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from flowabs_nodes import Image
from flowabs_nodes.array_types import Array
from flowabs_nodes.color import ColorSpace, ocio
from flowabs_nodes.errors import FlowabsError, ReadError
from flowabs_nodes.io import alpha as alphas
from flowabs_nodes.io import formats, nonfinite
from flowabs_nodes.io.read import quiet, read_image
from flowabs_nodes.io.settings import Settings

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
    return take(datablock, frame=frame, user=user).image(layer, note, warn)


@dataclass(frozen=True)
class Taken:
    """What there is to know of an Image datablock, so that any thread can make an image of it.

    Attributes
    ----------
    name
        The datablock's name, for messages.
    file
        The file that holds just what the datablock shows; else one of the next two is there.
    pixels
        (H, W, C) float32 as Blender holds them, the lowest row first: of a float picture scene-linear and
        premultiplied, else codes under straight alpha.
    content
        The bytes of a file that is packed into the .blend, and of which Blender shows no pixels.
    space, settings
        Blender's name of the colour space, and the settings under which flowabs knows it.
    is_data, is_float, alpha_mode
        As the datablock has them.
    working
        Blender's working space.
    """

    name: str
    file: Path | None
    pixels: Array | None
    content: bytes | None
    space: str
    settings: Settings
    is_data: bool
    is_float: bool
    alpha_mode: str
    working: ColorSpace

    def image(self, layer: str = "", note: Say = quiet, warn: Say = quiet) -> Image:
        """Return the image; parameters and errors are those of :func:`image_of`."""
        with _about(self.name):
            if self.file is not None:
                return self._read(self.file, layer, note, warn)
            if self.pixels is not None:
                return self._of_pixels(self.pixels, note)
            assert self.content is not None
            return self._unpacked(self.content, layer, note, warn)

    def _read(self, file: Path, layer: str, note: Say, warn: Say) -> Image:
        """Return the picture of a file, of the colours that Blender shows it in."""
        alpha = self._alpha(file)
        return read_image(
            file, layer=layer, colorspace=self.space, alpha=alpha, settings=self.settings, note=note, warn=warn
        )

    def _alpha(self, file: Path) -> str:
        """Return what alpha means, as ``read_image`` takes it: "auto" where Blender says what is usual there."""
        format = formats.by_extension(file)
        usual = "STRAIGHT" if format is not None and format.display_referred else "PREMUL"
        if self.alpha_mode in _OPAQUE:
            return "ignore"
        return (
            "auto" if self.alpha_mode == usual else {"STRAIGHT": "straight", "PREMUL": "premultiplied"}[self.alpha_mode]
        )

    def _unpacked(self, content: bytes, layer: str, note: Say, warn: Say) -> Image:
        """Return the picture of a file in memory."""
        format = formats.by_content(content[:16])
        if format is None:
            raise ReadError("the packed file is of no format that is read here", code="bad-format")
        with tempfile.TemporaryDirectory(prefix="flowabs-") as folder:
            file = Path(folder) / f"packed{format.extensions[0]}"
            file.write_bytes(content)
            return self._read(file, layer, note, warn)

    def _of_pixels(self, pixels: Array, note: Say) -> Image:
        """Return an image of Blender's pixels."""
        pixels, repairs = nonfinite.repaired(np.ascontiguousarray(pixels[::-1]), "repair")
        if repairs:
            note(repairs)
        alpha = pixels[..., -1] if pixels.shape[2] in (2, 4) and self.alpha_mode not in _OPAQUE else None
        if alpha is not None and (not alpha.any() or (alpha == 1).all()):
            alpha = None
        rgb = pixels[..., :3] if pixels.shape[2] > 2 else np.repeat(pixels[..., :1], 3, axis=2)
        space = self.working
        if not (self.is_float or self.is_data):
            rgb, space = ocio.linearize(rgb, self.space, self.settings.ocio)
        if alpha is not None:
            rgb = rgb if self.is_float else alphas.premultiplied(rgb, alpha)
            rgb = np.concatenate([rgb, alpha[..., None]], axis=2)
        return Image.from_array(rgb, space)


def take(datablock: bpy.types.Image, *, frame: int | None = None, user: bpy.types.ImageUser | None = None) -> Taken:
    """Take from Blender what an image is made of, quickly: files are read later. For the main thread alone.

    Parameters and errors are those of :func:`image_of`.
    """
    for kind in (datablock.type, datablock.source):
        if kind in _UNREADABLE:
            what, hint = _UNREADABLE[kind]
            raise ReadError(f"{named(datablock.name)} is {what}", code="no-pixels", hint=hint)
    with _about(datablock.name):
        path = path_of(datablock, frame=frame, user=user)
        file = path if holds_what_is_shown(datablock, path) else None
        pixels = _pixels(datablock) if file is None else None
        packed = datablock.packed_file
        if file is None and pixels is None and packed is None:  # of several packed layers Blender shows none by itself
            if path is None:
                raise ReadError("there are no pixels", code="no-pixels")
            missing = not path.exists()
            raise ReadError(
                "no such file"
                if missing
                else "Blender finds no pixels in it, and it is of no format that is read here",
                code="missing-file" if missing else "no-pixels",
                file=str(path),
            )
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


def named(name: str) -> str:
    """Return what messages call a datablock."""
    return f"image {name!r}"


@contextmanager
def _about(name: str) -> Iterator[None]:
    """Have errors say which datablock they are about."""
    try:
        yield
    except FlowabsError as error:
        error.message = f"{named(name)}: {error.message}"
        raise


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
