"""Pictures and graphs of the reader's own that pages start from, for the pages whose words name them.

A page gets ``shot.1001.exr`` because it says "with a sequence `shot.1001.exr` to ...". What a page does not say, it
does not get, but for the files of ``docs`` and ``graphs``: pages are read at the root of a checkout.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import OpenImageIO as oiio

from tests.docs.blocks import ROOT, Page

PICTURES = ROOT / "docs" / "pictures"
FRAMES = range(1001, 1011)


def small(name: str, width: int = 150) -> oiio.ImageBuf:
    """Return one of the documentation's pictures, made smaller, which keeps tests quick."""
    picture = oiio.ImageBuf(str(PICTURES / name))
    height = round(picture.spec().height * width / picture.spec().width)
    return oiio.ImageBufAlgo.resize(picture, roi=oiio.ROI(0, width, 0, height))


def write(picture: oiio.ImageBuf, file: Path, numbers: str = "half") -> None:
    """Write a picture in numbers of a type."""
    if not picture.write(str(file), numbers):
        raise OSError(picture.geterror())


def plate(file: Path) -> None:
    """Write a photograph."""
    write(small("coffee.exr"), file)


def shot(first: Path) -> None:
    """Write ten frames of a photograph that moves by a pixel a frame."""
    picture = small("coffee.exr")
    for offset, frame in enumerate(FRAMES):
        moved = oiio.ImageBufAlgo.circular_shift(picture, offset, 0)
        write(moved, first.with_name(first.name.replace(str(FRAMES[0]), str(frame))))


def render(file: Path) -> None:
    """Write a render with the passes that Blender makes: depth 1 to 60, normals, motion, an object's number."""
    beauty = small("render.exr").get_pixels()
    height, width = beauty.shape[:2]
    depth = np.linspace(60, 1, height)[:, None]
    passes = {
        **{f"Combined.{name}": beauty[..., n] for n, name in enumerate("RGB")},
        "Depth.Z": depth,
        "Normal.X": 0,
        "Normal.Y": 0,
        "Normal.Z": 1,
        **{f"Vector.{name}": 0 for name in "XYZW"},
        "IndexOB.X": depth > 20,
    }
    spec = oiio.ImageSpec(width, height, len(passes), "float")
    spec.channelnames = [f"ViewLayer.{name}" for name in passes]
    picture = oiio.ImageBuf(spec)
    pixels = np.stack([np.broadcast_to(each, (height, width)) for each in passes.values()], axis=-1)
    picture.set_pixels(spec.roi, np.ascontiguousarray(pixels, np.float32))
    write(picture, file, "float")


def passes_apart(first: Path) -> None:
    """Write the passes of :func:`render` into files of their own, each its file's only layer."""
    whole = first.with_name("whole.exr")
    render(whole)
    picture = oiio.ImageBuf(str(whole))
    files = {
        first.name: ("Combined", "RGB"),
        "z.1001.exr": ("Depth", "Z"),
        "n.1001.exr": ("Normal", "XYZ"),
        "motion.1001.exr": ("Vector", "XYZW"),
        "crypto.1001.exr": ("IndexOB", "X"),
        "crypto_material.1001.exr": ("IndexOB", "X"),
    }
    for name, (layer, letters) in files.items():
        order = tuple(f"ViewLayer.{layer}.{letter}" for letter in letters)
        write(oiio.ImageBufAlgo.channels(picture, order, tuple(letters)), first.with_name(name), "float")


def graph(file: Path) -> None:
    """Write a graph of the user's."""
    shutil.copy(ROOT / "graphs" / "lines.json", file)


#: What a page may start from, and the function that makes it.
SUPPLIES: dict[str, Callable[[Path], None]] = {
    "plate.exr": plate,
    "shot.1001.exr": shot,
    "render.1001.exr": render,
    "beauty.1001.exr": passes_apart,
    "my_graph.json": graph,
}


def supply(page: Page, folder: Path) -> None:
    """Put into a folder what the words of a page say is there."""
    for name, make in SUPPLIES.items():
        if f"`{name}`" in page.words:
            make(folder / name)
