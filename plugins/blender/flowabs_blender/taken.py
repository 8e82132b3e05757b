"""Holds what there is to know of a picture of Blender's, and makes an image of it in any thread."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flowabs_nodes import Image
from flowabs_nodes.array_types import Array
from flowabs_nodes.color import ColorSpace, ocio
from flowabs_nodes.errors import FlowabsError, ReadError
from flowabs_nodes.io import alpha as alphas
from flowabs_nodes.io import formats, nonfinite
from flowabs_nodes.io.read import quiet, read_image
from flowabs_nodes.io.settings import Settings

Say = Callable[[str], None]

#: What Blender says of an alpha that is none.
_OPAQUE = ("NONE", "CHANNEL_PACKED")


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
        """Return the image; ``layer`` is one of a file with several.

        ``note`` and ``warn`` are told what was found, and what is wrong with it. Raises ReadError for what cannot be
        read, ColorError where colours become NaN or Inf.
        """
        with about(self.name):
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
        if self.alpha_mode in _OPAQUE:
            return "ignore"
        format = formats.by_extension(file)
        usual = "STRAIGHT" if format is not None and format.display_referred else "PREMUL"
        said = {"STRAIGHT": "straight", "PREMUL": "premultiplied"}[self.alpha_mode]
        return "auto" if self.alpha_mode == usual else said

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


def named(name: str) -> str:
    """Return what messages call a datablock."""
    return f"image {name!r}"


@contextmanager
def about(name: str) -> Iterator[None]:
    """Have errors say which datablock they are about."""
    try:
        yield
    except FlowabsError as error:
        error.message = f"{named(name)}: {error.message}"
        raise
