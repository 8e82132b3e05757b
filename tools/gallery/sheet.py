"""Lay out a contact sheet, captioned panels in rows on white, and save it in a small file.

Text is drawn with the fonts that come in OpenImageIO's wheel, and left out where there are none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes.errors import WriteError
from flowabs_nodes.image import Image

Bytes = npt.NDArray[np.uint8]

GAP = 12  # between panels, and around all
SIZE = 15  # of text, in pixels
LINE = 19  # from one line of text to the next
LIMIT = 240_000  # bytes of a saved sheet
_INK = (25, 25, 25)
_GREY = (95, 95, 95)


@dataclass(frozen=True)
class Tile:
    """One panel: (H, W, 3) display pixels, its title, and smaller words under it."""

    pixels: Bytes
    title: str
    words: str = ""


def display(image: Image) -> Bytes:
    """Return an image as a screen shows it, (H, W, 3) uint8: colour as sRGB over white, mono and matte as they are."""
    pixels = image.pixels
    if image.type == "color":
        from flowabs_nodes.color import ocio

        rgb = pixels[..., :3] + (1 - pixels[..., 3:]) if pixels.shape[2] == 4 else pixels
        pixels = ocio.encode_named(rgb, image.colorspace, "srgb_rec709_scene")
    codes = np.rint(np.clip(pixels[..., :3], 0, 1) * 255).astype(np.uint8)
    return np.ascontiguousarray(np.broadcast_to(codes, (*codes.shape[:2], 3)))


def fitted(pixels: Bytes, width: int) -> Bytes:
    """Resize a picture to this width, if it is wider."""
    height, full = pixels.shape[:2]
    if full <= width:
        return pixels
    size = oiio.ROI(0, width, 0, round(height * width / full), 0, 1, 0, 3)
    small = oiio.ImageBufAlgo.resize(oiio.ImageBuf(np.ascontiguousarray(pixels)), filtername="lanczos3", roi=size)
    return np.asarray(small.get_pixels("uint8"), np.uint8)


def enlarged(pixels: Bytes, box: tuple[int, int, int, int], zoom: int = 1) -> Bytes:
    """Return the region (x, y, width, height) with each pixel as a square of ``zoom`` pixels."""
    x, y, width, height = box
    return np.ascontiguousarray(pixels[y : y + height, x : x + width].repeat(zoom, 0).repeat(zoom, 1))


def sheet(rows: Sequence[Sequence[Tile]]) -> Bytes:
    """Return all panels on one white picture, (H, W, 3) uint8."""
    heights = [max(tile.pixels.shape[0] + _text_height(tile) for tile in row) for row in rows]
    width = max(sum(tile.pixels.shape[1] + GAP for tile in row) for row in rows) + GAP
    canvas = np.full((sum(heights) + GAP * (len(rows) + 1), width, 3), 255, np.uint8)
    texts: list[tuple[int, int, str, tuple[int, int, int], bool]] = []
    y = GAP
    for row, height in zip(rows, heights, strict=True):
        x = GAP
        for tile in row:
            h, w = tile.pixels.shape[:2]
            canvas[y : y + h, x : x + w] = tile.pixels
            _frame(canvas[y : y + h, x : x + w])
            line = y + h + LINE - 2
            for words, color, bold in ((tile.title, _INK, True), (tile.words, _GREY, False)):
                for part in wrapped(words, w, bold):
                    texts.append((x, line, part, color, bold))
                    line += LINE
            x += w + GAP
        y += height + GAP
    return _written(canvas, texts)


def wrapped(words: str, width: int, bold: bool = False) -> list[str]:
    """Wrap text into lines no wider than ``width`` pixels; a word stays whole."""
    lines: list[str] = []
    for word in words.split():
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and oiio.ImageBufAlgo.text_size(longer, SIZE, _font(bold)).width <= width:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines


def save(pixels: Bytes, path: Path, limit: int = LIMIT) -> Path:
    """Write a sheet as PNG if that is small, else as the best JPEG under ``limit`` bytes; return the file's path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    for old in (path.with_suffix(".png"), path.with_suffix(".jpg")):
        old.unlink(missing_ok=True)
    grey = bool((pixels == pixels[..., :1]).all())
    written = _write(pixels[..., :1] if grey else pixels, path.with_suffix(".png"), None)
    if written.stat().st_size <= limit // 2:
        return written
    written.unlink()
    for quality in range(88, 40, -4):
        written = _write(pixels, path.with_suffix(".jpg"), quality)
        if written.stat().st_size <= limit:
            return written
    raise WriteError(f"a sheet of {pixels.shape[1]}x{pixels.shape[0]} does not fit in {limit} bytes", file=str(path))


def _text_height(tile: Tile) -> int:
    width = tile.pixels.shape[1]
    return LINE * (len(wrapped(tile.title, width, True)) + len(wrapped(tile.words, width)))


def _frame(panel: Bytes) -> None:
    for edge in (panel[0], panel[-1], panel[:, 0], panel[:, -1]):
        edge[:] = np.minimum(edge, 200)


def _font(bold: bool) -> str:
    return "DroidSans-Bold" if bold else "DroidSans"


def _written(canvas: Bytes, texts: Sequence[tuple[int, int, str, tuple[int, int, int], bool]]) -> Bytes:
    """Draw text on a picture, ``y`` being its base line."""
    buffer = oiio.ImageBuf(canvas)
    for x, y, words, color, bold in texts:
        shade = tuple(value / 255 for value in color)
        if not oiio.ImageBufAlgo.render_text(buffer, x, y, words, SIZE, _font(bold), shade):
            buffer.geterror()  # no such font: the page has the words
            break
    return np.asarray(buffer.get_pixels("uint8"), np.uint8)


def _write(pixels: Bytes, path: Path, quality: int | None) -> Path:
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], "uint8")
    if quality is not None:
        spec.attribute("Compression", f"jpeg:{quality}")
    else:
        spec.attribute("png:compressionLevel", 9)
    output = oiio.ImageOutput.create(str(path))
    if not (
        output and output.open(str(path), spec) and output.write_image(np.ascontiguousarray(pixels)) and output.close()
    ):
        raise WriteError(f"not written: {oiio.geterror()}", file=str(path))
    return path
