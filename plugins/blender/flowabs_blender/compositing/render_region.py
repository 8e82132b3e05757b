"""Writes into the EXR of a render region where in the frame it was: Blender leaves that out.

With *Crop to Render Region* Blender writes a small picture whose windows start at 0, 0, without it a whole frame that
is empty outside. Here both become what other programs write: the pixels of the region, in the display window of the
frame. Lengths that follow the picture's size, and the edges of the region, are then right.
"""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import OpenImageIO as oiio

from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image import Window

from .settings import size_of


def region_of(scene: bpy.types.Scene) -> Window:
    """Return the pixels of a scene's render region."""
    render, (width, height) = scene.render, size_of(scene)
    left, right = int(render.border_min_x * width), int(render.border_max_x * width)
    bottom, top = int(render.border_min_y * height), int(render.border_max_y * height)
    return Window(left, height - top, right - left, top - bottom)


def place(file: Path, region: Window, width: int, height: int) -> None:
    """Give every part of an EXR the pixels of a region of a frame (width, height), and the frame's display window.

    A file that is so already stays as it is. Raises FlowabsError where it cannot be read or written, or is of another
    size than both.
    """
    source = oiio.ImageInput.open(str(file))
    if source is None:
        raise FlowabsError(f"cannot be read: {oiio.geterror()}", file=str(file))
    try:
        specs, planes = [], []
        while source.seek_subimage(len(specs), 0):
            spec = source.spec()
            found = Window(spec.x, spec.y, spec.width, spec.height)
            if found == region and (spec.full_width, spec.full_height) == (width, height):
                return
            pixels = source.read_image(len(specs), 0, 0, spec.nchannels, oiio.FLOAT)
            planes.append(_cut(pixels, found, region, width, height, file))
            specs.append(_moved(spec, region, width, height))
    finally:
        source.close()
    _write(file, specs, planes)


def _cut(pixels: np.ndarray, found: Window, region: Window, width: int, height: int, file: Path) -> np.ndarray:
    """Return the pixels of a region, of those of it alone or of the whole frame."""
    if (found.width, found.height) == (region.width, region.height):
        return pixels
    if (found.width, found.height) == (width, height):
        rows, columns = slice(region.y, region.y + region.height), slice(region.x, region.x + region.width)
        return np.ascontiguousarray(pixels[rows, columns])
    sizes = f"{found.width}x{found.height}, neither of the region, {region.width}x{region.height}, nor {width}x{height}"
    raise FlowabsError(f"the render region is not placed: the file is of {sizes}", file=str(file))


def _moved(spec: oiio.ImageSpec, region: Window, width: int, height: int) -> oiio.ImageSpec:
    moved = oiio.ImageSpec(spec)
    moved.x, moved.y, moved.width, moved.height = region
    moved.full_x, moved.full_y, moved.full_width, moved.full_height = 0, 0, width, height
    return moved


def _write(file: Path, specs: list[oiio.ImageSpec], planes: list[np.ndarray]) -> None:
    """Write all parts, and put the file in the place of the old one when it is whole."""
    unfinished = file.with_name(f".{file.stem}.tmp.exr")
    try:
        output = oiio.ImageOutput.create(str(unfinished))
        if output is None or not output.open(str(unfinished), tuple(specs)):
            raise FlowabsError(f"cannot be written: {output.geterror() if output else oiio.geterror()}", file=str(file))
        for number, (spec, pixels) in enumerate(zip(specs, planes, strict=True)):
            opened = number == 0 or output.open(str(unfinished), spec, "AppendSubimage")
            if not opened or not output.write_image(pixels):
                raise FlowabsError(f"cannot be written: {output.geterror()}", file=str(file))
        if not output.close():
            raise FlowabsError(f"cannot be written: {output.geterror()}", file=str(file))
        unfinished.replace(file)
    finally:
        unfinished.unlink(missing_ok=True)
