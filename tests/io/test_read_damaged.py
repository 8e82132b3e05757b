"""Files that cannot be read: each a ReadError with file and reason, at once, in little memory, and never zeros."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes.errors import ReadError
from flowabs_nodes.io.read import read_data, read_image
from flowabs_nodes.io.write import is_whole
from tests.io.files import colors, deep, exr, flat, planes, raw_header


def refused(path: Path, match: str = ".") -> ReadError:
    """Assert that no reader takes a file, and that it counts as not whole; return the error."""
    for read in (read_image, read_data):
        with pytest.raises(ReadError, match=match) as caught:
            read(path)
        assert caught.value.file == str(path)
    assert not path.is_file() or not is_whole(path)
    return caught.value


def test_missing_empty_and_folders(tmp_path: Path) -> None:
    assert refused(tmp_path / "none.exr", "no such file").code == "missing-file"
    (tmp_path / "empty.exr").touch()
    refused(tmp_path / "empty.exr", "empty")
    (tmp_path / "folder.exr").mkdir()
    refused(tmp_path / "folder.exr", "folder")


def test_content_must_be_what_the_name_says(tmp_path: Path) -> None:
    """OpenImageIO opens whatever it finds."""
    png = flat(tmp_path / "a.png", np.zeros((4, 4, 3), np.uint8))
    wrong = tmp_path / "wrong.exr"
    wrong.write_bytes(png.read_bytes())
    assert oiio.ImageInput.open(str(wrong)).format_name() == "png"
    assert refused(wrong, "not an EXR file: it is a PNG file").code == "bad-format"
    wrong.write_text("hello world\n" * 100)
    refused(wrong, "does not begin as one")
    other = tmp_path / "a.cin"
    other.write_bytes(png.read_bytes())
    refused(other, "these are dpx, exr, jpg, jpeg, png, tif or tiff")


@pytest.mark.parametrize("compression", ["ZIP", "NO", "PIZ"])
def test_a_cut_exr_is_an_error_not_zeros(tmp_path: Path, compression: str) -> None:
    import OpenEXR

    path = exr(tmp_path / "cut.exr", planes(colors(80, 60)), compression=getattr(OpenEXR, f"{compression}_COMPRESSION"))
    whole = path.read_bytes()
    for size in (len(whole) - 1, len(whole) // 2, 600, 300, 100, 8, 4):
        path.write_bytes(whole[:size])
        refused(path, "damaged|not an OpenEXR file")


@pytest.mark.parametrize("name", ["a.png", "a.jpg", "a.tif"])
def test_other_formats_cut_short(tmp_path: Path, name: str) -> None:
    path = flat(tmp_path / name, (np.random.default_rng(0).random((200, 200, 3)) * 255).astype(np.uint8))
    assert is_whole(path)
    whole = path.read_bytes()
    for size in (len(whole) // 2, 8):
        path.write_bytes(whole[:size])
        refused(path)


def test_flipped_bits(tmp_path: Path) -> None:
    path = exr(tmp_path / "flip.exr", planes(colors(80, 60)))
    content = bytearray(path.read_bytes())
    for place in np.random.default_rng(0).integers(2000, len(content), 50):
        content[place] ^= 0xFF
    path.write_bytes(bytes(content))
    refused(path, "damaged")


def test_a_message_that_is_no_utf8(tmp_path: Path) -> None:
    """``geterror`` quotes the header, and raises UnicodeDecodeError where that is no text."""
    path = exr(tmp_path / "bad.exr", planes(colors(4, 4)))
    content = (
        path.read_bytes().replace(b"\0compression\0", b"\0co\xff\xfe\xfdession\0").replace(b"chlist", b"ch\xff\xfest")
    )
    path.write_bytes(content)
    refused(path, "damaged")


def test_deep_data(tmp_path: Path) -> None:
    path = deep(tmp_path / "deep.exr")
    with pytest.raises(ReadError, match="deep") as caught:
        read_image(path)
    assert caught.value.code == "deep"


WINDOWS = {
    "30k": (0, 0, 29999, 29999),
    "1M": (0, 0, 999_999, 999_999),
    "2G": (-(2**30), -(2**30), 2**30 - 2, 2**30 - 2),
    "wide": (0, 0, 2**20, 0),
    "16k": (0, 0, 16383, 16383),
    "inverted": (10, 10, 0, 0),
    "far": (2**31 - 10, 0, 2**31 - 1, 10),
}


@pytest.mark.parametrize("name", WINDOWS)
def test_header_bombs(tmp_path: Path, name: str) -> None:
    path = tmp_path / "bomb.exr"
    path.write_bytes(raw_header(WINDOWS[name], [(c, 1, 1) for c in "RGBA"]) + bytes(4096))
    start = time.process_time()
    refused(path)
    assert time.process_time() - start < 5  # a hundredth of that when alone


def test_a_small_file_of_a_large_picture(tmp_path: Path) -> None:
    """A whole and honest file whose pixels would take gigabytes: refused before any memory is taken."""
    path = tmp_path / "bomb.exr"
    output = oiio.ImageOutput.create(str(path))
    spec = oiio.ImageSpec(16384, 8448, 1, oiio.HALF)
    spec.channelnames = ("Y",)
    output.open(str(path), spec)
    rows = np.zeros((256, 16384, 1), np.float16)
    for y in range(0, 8448, 256):
        output.write_scanlines(y, y + 256, 0, rows)
    output.close()
    assert path.stat().st_size < 2_000_000
    assert refused(path, "more than 134,217,728 pixels").code == "too-large"


def test_a_bomb_takes_little_memory(tmp_path: Path) -> None:
    path = tmp_path / "bomb.exr"
    path.write_bytes(raw_header((0, 0, 11000, 11000), [(c, 1, 1) for c in "RGBA"], tiles=64) + bytes(40960))
    code = """
import resource, sys
from flowabs_nodes.io.read import read_image
from flowabs_nodes.errors import ReadError
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
try:
    read_image(sys.argv[1])
except ReadError:
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""
    pytest.importorskip("resource")
    done = subprocess.run(
        [sys.executable, "-c", code, str(path)], capture_output=True, text=True, timeout=60, check=True
    )
    assert int(done.stdout) < 200_000  # kilobytes
