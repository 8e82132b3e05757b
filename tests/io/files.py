"""Make the files that the tests read: EXR by the OpenEXR module, or byte by byte where nothing writes such a file."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import OpenImageIO as oiio

from flowabs_nodes.image import Image
from flowabs_nodes.io.attributes import values
from flowabs_nodes.io.output_image import build_picture
from flowabs_nodes.io.write import save

Planes = dict[str, np.ndarray]

DATA = (3, -2)  # corner of the data window of `windowed`
DISPLAY = (-5, 0, 40, 30)


def colors(height: int = 24, width: int = 32, channels: int = 3, seed: int = 1, dtype: Any = np.float16) -> np.ndarray:
    """Return (H, W, C) of smooth colour between 0 and 2 with a little noise; an alpha is between 0.1 and 1."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:height, :width]
    rgb = [1 + np.sin((x * (1 + c) + y) / 9 + c) for c in range(3)]
    pixels = np.stack(rgb, 2) + rng.random((height, width, 3)) * 0.05
    if channels == 4:
        alpha = 0.1 + 0.9 * (x[..., None] / max(width - 1, 1))
        pixels = np.concatenate([pixels * alpha, alpha], axis=2)
    return pixels.astype(dtype)


def planes(pixels: np.ndarray, names: str | tuple[str, ...] = "RGBA", layer: str = "") -> Planes:
    """Return one plane (H, W) per channel, as the OpenEXR module wants them."""
    prefix = f"{layer}." if layer else ""
    return {
        prefix + name: np.ascontiguousarray(pixels[..., i])
        for i, name in zip(range(pixels.shape[2]), names, strict=False)
    }


def box(x: int, y: int, width: int, height: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a window as EXR's box2i: first and last pixel."""
    return np.array([x, y], np.int32), np.array([x + width - 1, y + height - 1], np.int32)


def exr(path: Path, channels: Planes, **header: Any) -> Path:
    """Write a one-part EXR; zip-compressed scanlines unless ``header`` says else."""
    head = {"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION, **header}
    OpenEXR.File(head, dict(channels)).write(str(path))  # it puts its own objects into the dict
    return path


def parts(path: Path, *each: tuple[str, Planes, dict[str, Any]]) -> Path:
    """Write a multi-part EXR of (name, channels, header)."""
    made = []
    for name, channels, header in each:
        head = {"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION, **header}
        made.append(OpenEXR.Part(head, dict(channels), name))
    OpenEXR.File(made).write(str(path))
    return path


def windowed(path: Path, **header: Any) -> Path:
    """Write a half-float RGB plate with overscan and a negative corner."""
    pixels = colors()
    windows = {"dataWindow": box(*DATA, 32, 24), "displayWindow": box(*DISPLAY)}
    return exr(path, planes(pixels), **windows, **header)


def flat(path: Path, pixels: np.ndarray, **attributes: Any) -> Path:
    """Write a PNG, JPEG or TIFF; ``__`` in an attribute's name stands for ``:``. Alpha is straight."""
    kind = "float" if pixels.dtype == np.float32 else str(pixels.dtype)
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kind)
    spec.attribute("oiio:UnassociatedAlpha", 1)
    for name, value in attributes.items():
        spec.attribute(name.replace("__", ":"), value)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec), output.geterror()
    assert output.write_image(pixels)
    assert output.close()
    return path


def deep(path: Path) -> Path:
    """Write a deep EXR of 2x2 pixels with one sample each."""
    spec = oiio.ImageSpec(2, 2, 2, oiio.FLOAT)
    spec.channelnames = ("A", "Z")
    spec.deep = True
    data = oiio.DeepData()
    data.init(4, 2, [oiio.TypeFloat, oiio.TypeFloat], ["A", "Z"])
    for pixel in range(4):
        data.set_samples(pixel, 1)
        data.set_deep_value(pixel, 0, 0, 1.0)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec)
    assert output.write_deep_image(data)
    assert output.close()
    return path


def raw_header(window: tuple[int, int, int, int], channels: list[tuple[str, int, int]], tiles: int = 0) -> bytes:
    """Return an EXR header, byte by byte, without compression.

    ``window`` is x0, y0, x1, y1; ``channels`` are half, each (name, x sampling, y sampling); ``tiles`` is their size.
    """

    def attribute(name: str, kind: str, value: bytes) -> bytes:
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value

    listed = (
        b"".join(n.encode() + b"\0" + struct.pack("<iBxxxii", 1, 0, xs, ys) for n, xs, ys in sorted(channels)) + b"\0"
    )
    header = struct.pack("<ii", 20000630, 2 | (0x200 if tiles else 0))
    header += attribute("channels", "chlist", listed) + attribute("compression", "compression", b"\0")
    header += attribute("dataWindow", "box2i", struct.pack("<4i", *window))
    header += attribute("displayWindow", "box2i", struct.pack("<4i", *window)) + attribute(
        "lineOrder", "lineOrder", b"\0"
    )
    header += attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    header += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
    header += attribute("screenWindowWidth", "float", struct.pack("<f", 1))
    if tiles:
        header += attribute("tiles", "tiledesc", struct.pack("<IIB", tiles, tiles, 0))
    return header + b"\0"


def luminance_chroma(path: Path, channels: dict[str, tuple[np.ndarray, int]], corner: tuple[int, int] = (0, 0)) -> Path:
    """Write an EXR of half channels (plane, sampling), which no module does: one chunk a scanline, uncompressed."""
    height, width = next(plane.shape for plane, step in channels.values() if step == 1)
    x0, y0 = corner
    header = raw_header(
        (x0, y0, x0 + width - 1, y0 + height - 1), [(name, step, step) for name, (_, step) in channels.items()]
    )
    chunks = []
    rows = dict.fromkeys(channels, 0)
    for y in range(y0, y0 + height):
        line = b""
        for name in sorted(channels):
            plane, step = channels[name]
            if y % step == 0:
                line += plane[rows[name]].astype("<f2").tobytes()
                rows[name] += 1
        chunks.append(struct.pack("<ii", y, len(line)) + line)
    offsets, place = [], len(header) + 8 * height
    for chunk in chunks:
        offsets.append(place)
        place += len(chunk)
    path.write_bytes(header + struct.pack(f"<{height}Q", *offsets) + b"".join(chunks))
    return path


def attributes(path: Path, part: int = 0) -> dict[str, tuple[str, Any]]:
    """Return a file's metadata, name -> (type, value), without what describes its encoding."""
    source = oiio.ImageInput.open(str(path))
    assert source is not None
    assert source.seek_subimage(part, 0)
    encoding = ("openexr:", "compression", "oiio:RowsPerChunk", "oiio:subimages", "flowabs:", "thumbnail_")
    found = {name: value for name, value in values(source.spec()).items() if not name.startswith(encoding)}
    source.close()
    return found


def native(path: Path, part: int = 0) -> Planes:
    """Read every channel of a part in the file's own data type, by the OpenEXR module."""
    file = OpenEXR.File(str(path), separate_channels=True)
    return {name: channel.pixels for name, channel in file.parts[part].channels.items()}


def same_bits(a: np.ndarray, b: np.ndarray) -> bool:
    """Return True if shape, data type and every bit are equal: NaN equals the same NaN."""
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()


def written(
    image: Image, path: Path, *, layers: dict[str, Image] | None = None, **options: Any
) -> tuple[Path, list[str]]:
    """Write an image with the key "the key"; return the file and what it warned of."""
    warned: list[str] = []
    picture = build_picture(image, layers, warn=warned.append, **options)
    save(picture, path, key="the key", graph='{"a": "é"}', warn=warned.append)
    return path, warned


def like(image: Image, pixels: np.ndarray, type: Any = None) -> Image:
    """Return other pixels on an image's windows, with its metadata."""
    return image.with_pixels(np.asarray(pixels, np.float32), type)


def srgb_to_linear(codes: np.ndarray) -> np.ndarray:
    """Return the linear light of sRGB codes, 0..1, by the standard's own words (IEC 61966-2-1)."""
    return np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
