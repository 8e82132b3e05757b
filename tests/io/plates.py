"""Kinds of EXR plates, each as somebody's program may write it: by the OpenEXR module, or byte by byte."""

from __future__ import annotations

import struct
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import OpenEXR
import OpenImageIO as oiio

from tests.io.files import Planes, box, colors, exr, luminance_chroma, parts, planes

AP0 = (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767)
NOBODYS = (0.7, 0.3, 0.2, 0.75, 0.14, 0.05, 0.3, 0.32)
TIME = OpenEXR.TimeCode(1, 2, 3, 4, 1, 0, 1, 0, 1, 0, 1, 2, 3, 4, 5, 6, 7, 8)
BITS = np.random.default_rng(3).integers(0, 2**32, (24, 32), dtype=np.uint32)
NUMBERS = {"i": np.int32, "f": np.float32, "d": np.float64}

#: An attribute of every type that the OpenEXR module writes.
EVERY_TYPE: dict[str, Any] = {
    "an int": -7,
    "a/float": 1.25,
    "a double": np.array([0.1], np.float64),
    "text": "hé",
    "no text": "",
    "texts": ["a", "", "bb"],
    "floats": [1.0, 2.0, 3.0, 4.0, 5.0],
    **{f"v{n}{kind}": np.arange(n).astype(of) for n in (2, 3) for kind, of in NUMBERS.items()},
    **{f"m{n}{kind}": np.eye(n).astype(NUMBERS[kind]) * 3 for n in (3, 4) for kind in "fd"},
    "box2i": box(1, 2, 3, 4),
    "box2f": (np.array([1.5, 2], np.float32), np.array([3, 4], np.float32)),
    "fraction": Fraction(-1, 3),
    "a time": TIME,
    "a key": OpenEXR.KeyCode(1, 2, 3, 4, 5, 4, 64),
    "primaries": AP0,
    "a compression": OpenEXR.PIZ_COMPRESSION,
    "an order": OpenEXR.DECREASING_Y,
    "tiling": OpenEXR.TileDescription(),
    "envmap": OpenEXR.ENVMAP_CUBE,
    "nobody's": OpenEXR.OpaqueAttribute(b"\0\1\2\3", "mystery"),
}
#: Names that OpenImageIO has a meaning for, with values of another.
TAKEN_NAMES = {
    "oiio:mine": "x",
    "ICCProfile": "x",
    "tiff:note": "x",
    "thumbnail_width": 5,
    "Orientation": 6,
    "DateTime": "x",
    "Copyright": "x",
    "PixelAspectRatio": 3.0,
    "smpte:TimeCode": "x",
    "CICP": "x",
    "compressionLevel": 3,
}
#: Names that the standard has a meaning for.
STANDARD = {
    "owner": "Studio Ltd",
    "comments": "first pass",
    "capDate": "2004:01:04 18:10:00",
    "expTime": 0.5,
    "isoSpeed": 800.0,
    "imageCounter": 3,
    "wrapmodes": "clamp",
    "worldToCamera": np.eye(4, dtype=np.float32),
}


def plain(channels: int = 3, dtype: Any = np.float16, size: tuple[int, int] = (24, 32), layer: str = "") -> Planes:
    """Return planes of colour."""
    return planes(colors(*size, channels=channels, dtype=dtype), layer=layer)


def aovs() -> Planes:
    """Return half, float and uint planes, in which any bits may occur: NaN, Inf and denormals among them."""
    return {
        "Z": BITS.view(np.float32),
        "N.X": BITS.astype(np.uint16).view(np.float16),
        "id": BITS,
        "crypto00.red": BITS.T.copy().reshape(24, 32).view(np.float32),
        "diffuse.R": colors()[..., 0],
        "diffuse.a.b": colors()[..., 1],
    }


def patched(path: Path, stored: bytes, other: bytes, **header: Any) -> None:
    """Write a plate, and in its header other bytes than any module would write."""
    data = exr(path, plain(), **header).read_bytes()
    assert data.count(stored) == 1
    path.write_bytes(data.replace(stored, other))


def several_parts(path: Path) -> None:
    """Write parts with windows, compressions and attributes of their own, the picture among them."""
    full = {"dataWindow": box(0, 0, 32, 24), "displayWindow": box(0, 0, 40, 30), "pixelAspectRatio": 2.0}
    small = {"dataWindow": box(2, -3, 16, 12), "displayWindow": box(0, 0, 40, 30), "pixelAspectRatio": 2.0}
    parts(
        path,
        ("depth_left", {"Z": np.full((12, 16), 1e30, np.float32)}, small | {"compression": OpenEXR.ZIPS_COMPRESSION}),
        ("rgba_right", plain(4) | {"id": BITS}, full | {"view": "right", "note": "mine"}),
        ("rgba_left", plain(4), full | {"view": "left", "compression": OpenEXR.DWAA_COMPRESSION, "note": "other"}),
        ("ids", {"id": BITS, "half": colors()[..., 0]}, full | {"compression": OpenEXR.PIZ_COMPRESSION}),
    )


def mipmapped(path: Path) -> None:
    """Write tiles of several resolutions."""
    picture = exr(path.with_name("plain.exr"), plain(4, size=(64, 64)))
    assert oiio.ImageBufAlgo.make_texture(oiio.MakeTxTexture, oiio.ImageBuf(str(picture)), str(path))
    assert oiio.ImageBuf(str(path)).nmiplevels > 1


def chroma(path: Path) -> None:
    """Write luminance and chroma of half the size, with an alpha."""
    whole, half = np.full((24, 32), 0.5, np.float32), np.full((12, 16), 0.1, np.float32)
    luminance_chroma(path, {"Y": (whole, 1), "RY": (half, 2), "BY": (half, 2), "A": (whole, 1)})


class Kind(NamedTuple):
    """A kind of plate: how one is written, and the promises that it is there for. ``warns``: so does the run."""

    write: Callable[[Path], object]
    proves: str
    warns: str = ""
    ways: tuple[str, ...] = ("copy", "quantize")


def of(channels: Planes | None = None, **header: Any) -> Callable[[Path], object]:
    """Return a function that writes a plate of one part."""
    return lambda path: exr(path, channels if channels is not None else plain(), **header)


TILES = OpenEXR.TileDescription()
TILES.xSize, TILES.ySize = 16, 8
ZERO_ALPHA = plain(3) | {"A": np.zeros((24, 32), np.float16)}
ODD_ALPHA = plain(4, np.float32)
ODD_ALPHA["A"][0, :4] = (-0.5, 1.5, 0, 1e-38)
STEREO = plain() | plain(layer="left") | {"Z": BITS.view(np.float32), "left.Z": BITS.view(np.float32)}

KINDS: dict[str, Kind] = {
    # windows
    "overscan": Kind(
        of(dataWindow=box(-4, -3, 32, 24), displayWindow=box(0, 0, 24, 18)), "display window, data window"
    ),
    "cropped": Kind(of(dataWindow=box(5, 7, 32, 24), displayWindow=box(-2, 0, 60, 50)), "display window, data window"),
    "apart": Kind(of(dataWindow=box(50, 60, 32, 24), displayWindow=box(0, 0, 40, 30)), "display window, data window"),
    "anamorphic": Kind(of(pixelAspectRatio=2.0), "pixel aspect"),
    "shifted lens": Kind(of(screenWindowCenter=np.array([0.5, -1], np.float32), screenWindowWidth=1.5), "pixel aspect"),
    # colours
    "no tag": Kind(of(), "colour space"),
    "AP0": Kind(of(chromaticities=AP0), "chromaticities, colour space"),
    "nobody's primaries": Kind(of(chromaticities=NOBODYS), "chromaticities, colour space"),
    "interop": Kind(of(colorInteropID="lin_ap1_scene"), "chromaticities, colour space"),
    "white": Kind(
        of(chromaticities=AP0, whiteLuminance=100.0, adoptedNeutral=np.array([0.3, 0.3], np.float32)), "chromaticities"
    ),
    "ACES container": Kind(
        of(acesImageContainerFlag=1, chromaticities=AP0, compression=OpenEXR.NO_COMPRESSION), "attributes, compression"
    ),
    # header
    "time": Kind(
        of(timeCode=TIME, keyCode=OpenEXR.KeyCode(1, 2, 3, 4, 5, 4, 64), framesPerSecond=Fraction(24000, 1001)),
        "time code",
    ),
    "every type": Kind(of(**EVERY_TYPE), "attributes"),
    "standard": Kind(of(**STANDARD), "attributes"),
    "taken names": Kind(of(**TAKEN_NAMES), "attributes"),
    "long names": Kind(of(plain() | {"l" * 200 + ".Z": BITS}, **{"n" * 200: "v" * 5000}), "attributes, layers"),
    "rate not reduced": Kind(
        lambda path: patched(
            path, struct.pack("<iI", 24, 1), struct.pack("<iI", 24000, 1000), framesPerSecond=Fraction(24)
        ),
        "time code",
    ),
    "rate of 24/0": Kind(
        lambda path: patched(path, struct.pack("<iI", 24, 1), struct.pack("<iI", 24, 0), framesPerSecond=Fraction(24)),
        "time code",
    ),
    "key code out of range": Kind(
        lambda path: patched(
            path,
            struct.pack("<7i", 1, 2, 3, 4, 5, 4, 64),
            struct.pack("<7i", 100, -2, 3, 4, 500, 40, 640),
            keyCode=OpenEXR.KeyCode(1, 2, 3, 4, 5, 4, 64),
        ),
        "time code",
    ),
    "Latin-1": Kind(lambda path: patched(path, b"Andr?", b"Andr\xe9", owner="Andr?"), "attributes"),
    "Latin-1 texts": Kind(lambda path: patched(path, b"Andr?", b"Andr\xe9", names=["Andr?", "b"]), "attributes"),
    "no such environment": Kind(
        lambda path: patched(path, b"envmap\0\1\0\0\0\1", b"envmap\0\1\0\0\0\7", envmap=OpenEXR.ENVMAP_CUBE, take=3),
        "attributes",
        warns="left out: envmap",
    ),
    "standard names of other types": Kind(
        lambda path: patched(path, b"Qdopted", b"adopted", QdoptedNeutral="text", take=3),
        "attributes",
        warns="left out: adoptedNeutral",
    ),
    "manifest": Kind(
        of(plain() | aovs(), **{"cryptomatte/abc/manifest": '{"bunny":"deadbeef"}'}), "attributes, layers"
    ),
    # channels
    "half": Kind(of(plain(4)), "colours, alpha"),
    "float": Kind(of(plain(4, np.float32)), "colours, alpha"),
    "half and float": Kind(of(plain() | {"A": np.full((24, 32), 0.1, np.float32)}), "colours, alpha"),
    "alpha of 0": Kind(of(ZERO_ALPHA), "alpha, colours"),
    "alpha beyond 0..1": Kind(of(ODD_ALPHA), "alpha, colours"),
    "AOVs of any bits": Kind(of(plain(4) | aovs()), "layers, alpha"),
    "any order": Kind(
        of({"x.Z": BITS} | dict(reversed(plain(4).items())) | {"AA": BITS, "a.B": BITS}), "layers, colours"
    ),
    "grey": Kind(of({"Y": colors()[..., 0]}), "colours"),
    "grey and alpha": Kind(of({"Y": colors()[..., 0], "A": colors(channels=4)[..., 3]}), "colours, alpha"),
    "small letters": Kind(of(dict(zip("rgba", plain(4).values(), strict=True))), "colours, alpha"),
    "Blender": Kind(of(plain(4, layer="ViewLayer.Combined") | {"ViewLayer.Depth.Z": BITS.view(np.float32)}), "layers"),
    "luminance and chroma": Kind(chroma, "alpha"),
    "no colour": Kind(of(aovs() | {"id": colors()[..., 0]}), "colours", "NaN written as they are", ("data",)),
    "stereo": Kind(of(STEREO, multiView=["right", "left"]), "layers, attributes"),
    "several parts": Kind(several_parts, "layers, data window, pixel aspect, attributes, alpha"),
    # sizes and storage
    **{
        f"{width} x {height}": Kind(of(plain(4, size=(height, width))), "data window, colours")
        for width, height in ((1, 1), (1, 40), (40, 1), (17, 13))
    },
    "tiles": Kind(of(type=OpenEXR.tiledimage, tiles=TILES, owner="me"), "attributes, colours"),
    "mipmap": Kind(mipmapped, "colours"),
    "from below": Kind(of(lineOrder=OpenEXR.DECREASING_Y), "colours"),
    **{
        f"{name} {np.dtype(kind).name}": Kind(
            of(plain(4, kind), compression=getattr(OpenEXR, f"{name}_COMPRESSION")), "compression"
        )
        for name in ("NO", "RLE", "ZIPS", "ZIP", "PIZ", "PXR24", "B44", "B44A", "DWAA", "DWAB", "HTJ2K32", "HTJ2K256")
        for kind in (np.float16, np.float32)
        if hasattr(OpenEXR, f"{name}_COMPRESSION")
    },
}
