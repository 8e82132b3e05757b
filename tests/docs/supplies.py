"""Pictures and graphs of the reader's own that pages start from, for the pages whose words name them.

A page gets ``shot.1001.exr`` because it says "with a sequence `shot.1001.exr` to ...": what a page does not say, it does not get.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from functools import cache
from pathlib import Path

import OpenImageIO as oiio

from tests.docs.blocks import ROOT, Page

PICTURES = ROOT / "docs" / "pictures"
FRAMES = range(1001, 1011)


@cache
def small(name: str, width: int = 150) -> oiio.ImageBuf:
    """Return one of the documentation's pictures, made smaller: keeps tests quick."""
    picture = oiio.ImageBuf(str(PICTURES / name))
    height = round(picture.spec().height * width / picture.spec().width)
    return oiio.ImageBufAlgo.resize(picture, roi=oiio.ROI(0, width, 0, height))


def write(picture: oiio.ImageBuf, file: Path) -> None:
    """Write a picture as half floats."""
    if not picture.write(str(file), "half"):
        raise OSError(picture.geterror())


def plate(file: Path) -> None:
    """Write a photograph."""
    write(small("coffee.exr"), file)


def shot(first: Path) -> None:
    """Write ten frames of a photograph that moves by a pixel a frame."""
    for offset, frame in enumerate(FRAMES):
        moved = oiio.ImageBufAlgo.circular_shift(small("coffee.exr"), offset, 0)
        write(moved, first.with_name(first.name.replace(str(FRAMES[0]), str(frame))))


def render(file: Path) -> None:
    """Write a render with the passes that Blender makes: depth 1 to 50, normals, motion, an object index."""
    beauty = small("render.exr")
    spec = beauty.spec()
    roi = oiio.ROI(0, spec.width, 0, spec.height, 0, 1, 0, 10)
    names = [
        *("ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B", "ViewLayer.Depth.Z"),
        *("ViewLayer.Normal.X", "ViewLayer.Normal.Y", "ViewLayer.Normal.Z"),
        *("ViewLayer.Vector.X", "ViewLayer.Vector.Y", "ViewLayer.Vector.Z", "ViewLayer.Vector.W"),
        "ViewLayer.IndexOB.X",
    ]
    roi.chend = len(names)
    passes = oiio.ImageBufAlgo.fill((0,) * 3 + (1,) + (0, 0, 1) + (0,) * 4 + (1,), (0,) * 3 + (50,) + (0, 0, 1) + (0,) * 4 + (2,), roi)
    oiio.ImageBufAlgo.paste(passes, 0, 0, 0, 0, beauty)
    passes.specmod().channelnames = names
    if not passes.write(str(file), "float"):
        raise OSError(passes.geterror())


def graph(file: Path) -> None:
    """Copy a graph of the checkout's under its name, or the lines as a graph of the user's."""
    shutil.copy(ROOT / "graphs" / file.name if file.parent.name == "graphs" else ROOT / "graphs" / "lines.json", file)


def pictures(folder: Path) -> None:
    """Copy the documentation's pictures."""
    shutil.copytree(PICTURES, folder)


#: What a page may start from, and the function that makes it.
SUPPLIES: dict[str, Callable[[Path], None]] = {
    "docs/pictures": pictures,
    "plate.exr": plate,
    "shot.1001.exr": shot,
    "render.1001.exr": render,
    "my_graph.json": graph,
    "graphs/abstraction.json": graph,
}


def supply(page: Page, folder: Path) -> None:
    """Put into a folder what the words of a page say is there."""
    for name, make in SUPPLIES.items():
        if re.search(rf"`{re.escape(name)}/?`|\]\({re.escape(name)}", page.words):
            file = folder / name
            file.parent.mkdir(parents=True, exist_ok=True)
            make(file)
