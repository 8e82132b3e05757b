"""Find or make the figures' inputs: photographs in ``docs/pictures``, and pictures drawn or damaged by code.

The latter are written to a folder of inputs, so that a graph can be run on the same file from the command line.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import OpenImageIO as oiio

import flowabs_nodes
from flowabs_nodes.errors import ReadError, WriteError
from flowabs_nodes.filters import blur
from flowabs_nodes.image import Image
from flowabs_nodes.io.read import read_image
from flowabs_nodes.io.settings import Settings
from tools.gallery import drawings
from tools.gallery.sheet import Bytes, display


def blobs(size: int = 200, scale: float = 2.0, spread: float = 30.0, seed: int = 3) -> drawings.Array:
    """Draw Fig. 19a: small texture without direction, noise blurred by ``scale`` pixels, with a little noise on it."""
    draws = np.random.default_rng(seed).standard_normal((2, size, size)).astype(np.float32)
    soft = blur(draws[0], scale)
    return np.asarray(128 + spread * soft / soft.std() + 4 * draws[1], np.float32)


#: Drawings, by the name of the picture.
DRAWN: dict[str, Callable[[], drawings.Array]] = {
    "circle": drawings.dots_on_circle,
    "x": drawings.dots_x,
    "t": drawings.dots_t,
    "disc": drawings.disc_in_noise,
    "texture": drawings.small_texture,
    "blobs": blobs,
}
#: Damaged photographs: of which picture, of which region (x, y, width, height), and how.
DAMAGED: dict[str, tuple[str, tuple[int, int, int, int], Callable[[Bytes], Bytes]]] = {
    "noisy": ("coffee.exr", (120, 0, 320, 240), drawings.noisy),
    "blocky": ("chelsea.png", (0, 0, 451, 300), drawings.jpeg_damaged),
}


def pictures() -> Path:
    """Return the folder of photographs, in a checkout."""
    folder = Path(flowabs_nodes.__file__).resolve().parent.parent / "docs" / "pictures"
    if not folder.is_dir():
        raise ReadError(f"the gallery's photographs are not there: {folder}", hint="run it from a checkout")
    return folder


def file_of(name: str, folder: Path) -> Path:
    """Return the file of a picture; write a drawn or damaged one into ``folder`` first."""
    if name in DRAWN:
        # Half float: noise goes below black and above white, and stays.
        return _write(drawings.scene_linear(DRAWN[name]())[..., :1], folder / f"{name}.exr", "half", ("Y",))
    if name in DAMAGED:
        return _write(DAMAGED[name][2](clean(name)), folder / f"{name}.png", "uint8", ("R", "G", "B"))
    return pictures() / name


def clean(name: str) -> Bytes:
    """Return a damaged photograph as it was before: (H, W, 3) display pixels."""
    source, (x, y, width, height), _ = DAMAGED[name]
    return np.ascontiguousarray(display(_read(pictures() / source))[y : y + height, x : x + width])


def _read(path: Path) -> Image:
    return read_image(path, settings=Settings(), note=_quiet, warn=_quiet)


def _quiet(message: str) -> None:
    """Silence the log: a photograph's colour space is known."""


def _write(pixels: drawings.Array | Bytes, path: Path, kind: str, channels: tuple[str, ...]) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], len(channels), kind)
    spec.channelnames = channels
    spec.attribute("DateTime", "2009:01:01 00:00:00")  # else EXR takes the time of day: another file each time
    output = oiio.ImageOutput.create(str(path))
    packed = np.ascontiguousarray(pixels)
    if not (output and output.open(str(path), spec) and output.write_image(packed) and output.close()):
        raise WriteError(f"not written: {oiio.geterror()}", file=str(path))
    return path
