"""Show a sequence: all frames on one contact sheet, and as an animated GIF that plays in a page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
from scipy.cluster import vq  # type: ignore[import-untyped]

from flowabs_nodes.errors import WriteError
from tools.gallery.sheet import Bytes, Tile, fitted, save, sheet


def contact_sheet(frames: dict[int, Bytes], path: Path, columns: int, width: int, limit: int) -> Path:
    """Write frames, (H, W, 3) display pixels by number, in rows with their numbers; return the file's path."""
    tiles = [Tile(fitted(pixels, width), str(number)) for number, pixels in frames.items()]
    rows = [tiles[first : first + columns] for first in range(0, len(tiles), columns)]
    return save(sheet(rows), path, limit)


def animation(frames: Sequence[Bytes], path: Path, rate: int, width: int, colors: int = 256) -> Path:
    """Write frames as a GIF that goes on for ever, ``rate`` frames a second; return the file's path.

    Below 256, all frames share ``colors`` colours: a smaller file, whose flat areas do not flicker.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    pictures = [fitted(each, width) for each in frames]
    if colors < 256:
        pictures = _in_one_palette(pictures, colors)
    height, across = pictures[0].shape[:2]
    specs = tuple(oiio.ImageSpec(across, height, 3, "uint8") for _ in pictures)
    for spec in specs:
        spec.attribute("FramesPerSecond", oiio.TypeDesc("rational"), (rate, 1))
    output = oiio.ImageOutput.create(str(path))
    if not (output and output.open(str(path), specs) and _appended(output, path, specs, pictures) and output.close()):
        raise WriteError(f"not written: {oiio.geterror()}", file=str(path))
    return path


def _appended(output: Any, path: Path, specs: Sequence[Any], pictures: Sequence[Bytes]) -> bool:
    """Write pictures one after the other into a file that is open for the first; return whether all went well."""
    return all(
        (place == 0 or output.open(str(path), spec, "AppendSubimage"))
        and output.write_image(np.ascontiguousarray(picture))
        for place, (spec, picture) in enumerate(zip(specs, pictures, strict=True))
    )


def _in_one_palette(pictures: Sequence[Bytes], colors: int) -> list[Bytes]:
    """Return pictures with each pixel the nearest of the colours that fit all of them best (k-means)."""
    samples = np.concatenate([each[::4, ::4].reshape(-1, 3) for each in pictures]).astype(np.float64)
    colors = min(colors, len(np.unique(samples, axis=0)))
    palette, _ = vq.kmeans2(samples, colors, minit="++", seed=1)
    palette = np.rint(palette).clip(0, 255)
    return [
        palette[vq.vq(each.reshape(-1, 3).astype(float), palette)[0]].reshape(each.shape).astype(np.uint8)
        for each in pictures
    ]
