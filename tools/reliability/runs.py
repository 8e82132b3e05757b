"""Runs that are meant to be hurt: a folder with a sequence, the command over it, and what the folder holds then."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import OpenImageIO as oiio

CHECKOUT = Path(__file__).parents[2]
PICTURE = CHECKOUT / "docs/pictures/coffee.exr"

#: A run in a process that takes its first argument for the machine's name.
_ON_A_HOST = """
import socket, sys
name = sys.argv.pop(1)
socket.gethostname = lambda: name
from flowabs_nodes.cli import run_process
run_process()
"""

#: Width and height in pixels.
Size = tuple[int, int]


@dataclass(frozen=True)
class Shot:
    """A folder with a sequence of one picture."""

    folder: Path
    frames: int

    @property
    def made(self) -> Path:
        """Return the folder that frames are written to."""
        return self.folder / "out"

    def begin(
        self, *options: str, graph: str = "lines", host: str = "", stderr: Any = subprocess.PIPE, **environment: str
    ) -> subprocess.Popen[str]:
        """Begin a run over all frames; with ``host`` it takes the machine's name for this one."""
        module = ["-c", _ON_A_HOST, host] if host else ["-m", "flowabs_nodes"]
        command = [sys.executable, *module, "run", graph, *options]
        command += ["-i", str(self.folder / "plate.####.exr"), "-o", str(self.made / "lines.####.exr")]
        pipes: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": stderr, "text": True}
        return subprocess.Popen(command, env={**os.environ, "PYTHONPATH": str(CHECKOUT), **environment}, **pipes)

    def files(self) -> tuple[set[str], set[str]]:
        """Return the names of the frames that are there, and those of all other files."""
        names = set(os.listdir(self.made)) if self.made.exists() else set()
        frames = {name for name in names if name.startswith("lines.") and name.endswith(".exr")}
        return frames, names - frames

    def damaged(self) -> list[str]:
        """Return the names of frames that do not decode."""
        frames, _ = self.files()
        return [name for name in sorted(frames) if not decodes(self.made / name)]


@contextmanager
def shot(frames: int, size: Size | None = None) -> Iterator[Shot]:
    """Give a folder with so many frames, all one picture, of another size where one is given; removed at the end."""
    with tempfile.TemporaryDirectory() as name:
        first = Path(name) / "plate.0001.exr"
        if size is None:
            shutil.copyfile(PICTURE, first)
        else:
            resized(PICTURE, first, size)
        for frame in range(2, frames + 1):
            os.link(first, first.with_name(f"plate.{frame:04}.exr"))
        yield Shot(Path(name), frames)


def size_of(text: str) -> Size:
    """Return the width and height that ``1920x1080`` means. Raises ValueError."""
    width, height = map(int, text.split("x"))
    return width, height


def resized(picture: Path, to: Path, size: Size) -> None:
    """Write a picture in another size, as half floats."""
    width, height = size
    made = oiio.ImageBufAlgo.resize(oiio.ImageBuf(str(picture)), roi=oiio.ROI(0, width, 0, height, 0, 1, 0, 3))
    made.specmod().set_format(oiio.HALF)
    if made.has_error or not made.write(str(to)):
        raise RuntimeError(made.geterror())


def pixels_of(path: Path) -> bytes:
    """Return all pixels of a file."""
    pixels = oiio.ImageBuf(str(path)).get_pixels(oiio.FLOAT)
    if pixels is None:
        raise RuntimeError(f"{path} cannot be read")
    return pixels.tobytes()


def decodes(path: Path) -> bool:
    """Return whether every pixel of a file can be read."""
    opened = oiio.ImageInput.open(str(path))
    if opened is None:
        return False
    try:
        return opened.read_image() is not None
    finally:
        opened.close()
