"""A picture that is too large is refused, whether it is read or written; the hint says how to raise the limit."""

from __future__ import annotations

import resource
import struct
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes.errors import ReadError, WriteError
from flowabs_nodes.io.limits import check_display_window, check_readable, too_large
from flowabs_nodes.io.read import read_data, read_image
from flowabs_nodes.io.settings import Settings
from tests.io.files import exr, windowed


def test_what_is_read_has_a_limit_in_pixels_and_in_values(tmp_path: Path) -> None:
    path = windowed(tmp_path / "plate.exr")
    read_image(path, settings=Settings(max_pixels=32 * 24))
    with pytest.raises(ReadError, match="32x24 is more than 767 pixels") as caught:
        read_image(path, settings=Settings(max_pixels=32 * 24 - 1))
    assert caught.value.code == "too-large"
    many = {f"c{i:02}": np.zeros((4, 4), np.float16) for i in range(20)}
    with pytest.raises(ReadError, match="20 channels are too many"):
        read_data(exr(tmp_path / "many.exr", many), settings=Settings(max_pixels=16))


@pytest.mark.parametrize("size", [(0, 5, 1), (5, 0, 1), (5, 5, 2)])
def test_no_picture_at_all(size: tuple[int, int, int]) -> None:
    spec = oiio.ImageSpec(size[0], size[1], 3, "half")
    spec.depth = size[2]
    with pytest.raises(ReadError, match="not a picture"):
        check_readable("a.exr", spec, 3, Settings())


def test_what_is_written_has_the_same_limit() -> None:
    settings = Settings(max_pixels=100)
    assert not too_large(10, 10, settings)
    assert too_large(101, 1, settings)
    check_display_window(10, 10, settings)
    with pytest.raises(WriteError, match="11x10 is too large") as caught:
        check_display_window(11, 10, settings)
    assert caught.value.code == "too-large"


def exr_of_channels(path: Path, count: int) -> Path:
    """Write an EXR, 2 x 2 half, uncompressed, of so many channels, byte by byte."""

    def attribute(name: bytes, kind: bytes, value: bytes) -> bytes:
        return name + b"\0" + kind + b"\0" + struct.pack("<I", len(value)) + value

    names = b"".join(b"c%06d\0" % index + struct.pack("<iBxxxii", 1, 0, 1, 1) for index in range(count)) + b"\0"
    box = struct.pack("<4i", 0, 0, 1, 1)
    header = b"\x76\x2f\x31\x01\2\0\0\0" + attribute(b"compression", b"compression", b"\0")
    header += attribute(b"channels", b"chlist", names) + attribute(b"dataWindow", b"box2i", box)
    header += attribute(b"displayWindow", b"box2i", box) + attribute(b"lineOrder", b"lineOrder", b"\0")
    header += attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1))
    header += attribute(b"screenWindowCenter", b"v2f", bytes(8))
    header += attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1)) + b"\0"
    row = struct.pack("<i", 4 * count) + bytes(4 * count)
    first = len(header) + 16
    rows = [struct.pack("<i", y) + row for y in (0, 1)]
    path.write_bytes(header + struct.pack("<QQ", first, first + len(rows[0])) + b"".join(rows))
    return path


def tiff_of_pages(path: Path, count: int) -> Path:
    """Write a TIFF of so many grey pages, 2 x 2, which all have the same four bytes for pixels."""
    tags = [(256, 2), (257, 2), (258, 8), (259, 1), (262, 1), (273, 8), (277, 1), (278, 2), (279, 4)]
    entries = b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags)
    size = 2 + len(entries) + 4
    pages = [
        struct.pack("<H", len(tags)) + entries + struct.pack("<I", 12 + size * (page + 1) if page < count - 1 else 0)
        for page in range(count)
    ]
    path.write_bytes(b"II*\0" + struct.pack("<I", 12) + bytes(4) + b"".join(pages))
    return path


def jpeg_of_size(path: Path, side: int) -> Path:
    """Write a JPEG of 16 x 16 whose header says ``side`` x ``side``."""
    spec = oiio.ImageSpec(16, 16, 3, "uint8")
    buf = oiio.ImageBuf(spec)
    assert buf.write(str(path)), buf.geterror()
    content = bytearray(path.read_bytes())
    at = content.index(b"\xff\xc0") + 5
    content[at : at + 4] = struct.pack(">HH", side, side)
    path.write_bytes(content)
    return path


@pytest.mark.parametrize(
    ("make", "extension", "count", "code"),
    [
        (exr_of_channels, "exr", 100_000, "too-large"),
        (exr_of_channels, "exr", 4097, "too-large"),
        (tiff_of_pages, "tif", 60_000, "too-large"),
        (jpeg_of_size, "jpg", 11_500, "damaged"),
    ],
)
def test_a_file_that_says_more_than_it_can_hold_is_refused_at_once(tmp_path, make, extension, count, code):
    path = make(tmp_path / f"hostile.{extension}", count)
    for read in (read_image, read_data):
        before = resource.getrusage(resource.RUSAGE_SELF)
        with pytest.raises(ReadError) as caught:
            read(path)
        after = resource.getrusage(resource.RUSAGE_SELF)
        assert caught.value.code == code
        assert after.ru_utime - before.ru_utime < 2
        assert after.ru_maxrss - before.ru_maxrss < 300_000


def test_what_is_just_within_the_limits_is_read(tmp_path):
    assert read_data(exr_of_channels(tmp_path / "many.exr", 40)).channels == tuple(f"c{i:06d}" for i in range(40))
    assert read_image(tiff_of_pages(tmp_path / "pages.tif", 100)).pixels.shape[:2] == (2, 2)
    assert read_image(jpeg_of_size(tmp_path / "good.jpg", 16)).pixels.shape[:2] == (16, 16)
