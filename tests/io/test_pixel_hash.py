"""A hash of the pixels travels with every file that a run writes, and shows whether any of them has changed."""

from __future__ import annotations

import io
import struct
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import OpenImageIO as oiio
import pytest

from flowabs_nodes.image import Image
from flowabs_nodes.io.output_image import build_picture
from flowabs_nodes.io.pixel_hash import DecodedHash, chunk_hash, decoded_hash
from flowabs_nodes.io.provenance import stored_stamp
from flowabs_nodes.io.read import read_image
from flowabs_nodes.io.verify import flaw
from flowabs_nodes.io.write import save
from tests.io.files import colors, parts, planes

COMPRESSIONS = ["none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"]


def saved(path: Path, **how: Any) -> Path:
    image = Image.from_array(colors(60, 50).astype(np.float32))
    save(build_picture(image, **how), path, key="k", graph='{"name": "toon"}', scale=0.5)
    return path


def pixels_of(path: Path) -> str:
    stamp = stored_stamp(path)
    assert stamp is not None
    assert (stamp.key, stamp.graph, stamp.scale, len(stamp.pixels)) == ("k", "toon", 0.5, 40)
    return stamp.pixels


def flipped(path: Path, back: int) -> None:
    """Change one byte, that many before the end."""
    data = bytearray(path.read_bytes())
    data[-back] ^= 1
    path.write_bytes(data)


@pytest.mark.parametrize("compression", COMPRESSIONS)
@pytest.mark.parametrize("data_type", ["half", "float"])
def test_a_changed_byte_of_an_exr_shows(tmp_path: Path, compression: str, data_type: str) -> None:
    path = saved(tmp_path / "a.exr", compression=compression, data_type=data_type)
    assert flaw(path, pixels_of(path)) == ""
    assert flaw(path, "0" * 40) == "changed"
    flipped(path, back=3)
    assert flaw(path, pixels_of(path)) in ("changed", "damaged")
    if compression == "none":
        assert flaw(path) == "", "nothing else shows it"


@pytest.mark.parametrize(
    ("name", "data_type"), [("a.png", "uint8"), ("a.png", "uint16"), ("a.tif", "uint8"), ("a.tif", "float")]
)
@pytest.mark.parametrize("alpha", [True, False])
def test_a_changed_pixel_of_a_picture_shows(tmp_path: Path, name: str, data_type: str, alpha: bool) -> None:
    rgb = colors(60, 50).astype(np.float32)
    straight = np.dstack([rgb, np.linspace(0, 1, rgb[..., 0].size, dtype=np.float32).reshape(rgb.shape[:2])])
    image = Image.from_array(straight if alpha else rgb)
    path = tmp_path / name
    save(build_picture(image, data_type=data_type), path, key="k", graph='{"name": "toon"}', scale=0.5)
    assert flaw(path, pixels_of(path)) == ""
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(str(path), config)
    spec = oiio.ImageSpec(source.spec())
    pixels = np.array(source.read_image(spec.format))
    source.close()
    pixels[30, 20, 1] = 0 if pixels[30, 20, 1] else 1
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec)
    assert output.write_image(pixels)
    assert output.close()
    assert flaw(path, pixels_of(path)) == "changed"


def test_layers_and_kept_parts_are_among_the_pixels(tmp_path: Path) -> None:
    plate = parts(
        tmp_path / "plate.exr",
        ("rgba", planes(colors(60, 50)), {}),
        ("second", planes(colors(60, 50, seed=2)), {"compression": OpenEXR.NO_COMPRESSION, "flowabs:key": "other"}),
    )
    image = read_image(plate)
    path = tmp_path / "a.exr"
    picture = build_picture(image, layers={"more": image}, keep_layers="*")
    save(picture, path, key="k", graph='{"name": "toon"}', scale=0.5)
    found = OpenEXR.File(str(path), header_only=True).parts
    assert [part.header.get("flowabs:pixels", "") != "" for part in found] == [True, False]
    assert "flowabs:key" not in found[1].header
    assert flaw(path, pixels_of(path)) == ""
    flipped(path, back=2)  # in the last part, which is not compressed
    assert flaw(path) == ""
    assert flaw(path, pixels_of(path)) == "changed"


def test_what_is_written_into_a_header_later_is_no_change(tmp_path: Path) -> None:
    path = saved(tmp_path / "a.exr", compression="dwaa")
    data = path.read_bytes()
    before = pixels_of(path)
    more = b"note\0string\0" + struct.pack("<i", 5) + b"hello"
    count = -(-60 // 32)
    begin = struct.unpack_from("<Q", data, chunks := len(data) - sum_of_chunks(data, count) - 8 * count)[0]
    assert begin == chunks + 8 * count
    moved = [offset + len(more) for offset in struct.unpack_from(f"<{count}Q", data, chunks)]
    path.write_bytes(data[:8] + more + data[8:chunks] + struct.pack(f"<{count}Q", *moved) + data[chunks + 8 * count :])
    assert OpenEXR.File(str(path), header_only=True).header()["note"] == "hello"
    assert flaw(path, before) == ""


def sum_of_chunks(data: bytes, count: int) -> int:
    """Return how many bytes the chunks at the end of a file take: (y, size, data) each."""
    for start in range(len(data)):
        place = start
        for _ in range(count):
            if place + 8 > len(data):
                break
            size = struct.unpack_from("<i", data, place + 4)[0]
            if not 0 < size < len(data):
                break
            place += 8 + size
        else:
            if place == len(data) and struct.unpack_from("<i", data, start)[0] == 0:
                return len(data) - start
    raise AssertionError("no chunks")


def test_a_file_without_a_key_has_no_hash(tmp_path: Path) -> None:
    for name in ("a.exr", "a.png", "a.tif"):
        save(build_picture(Image.from_array(colors().astype(np.float32))), tmp_path / name)
        stamp = stored_stamp(tmp_path / name)
        assert stamp is not None
        assert stamp.pixels == ""


@pytest.mark.parametrize("short", [0, 3, 8, 9, 40, 200, 400])
def test_a_header_that_is_cut_short_is_no_hash(tmp_path: Path, short: int) -> None:
    data = saved(tmp_path / "a.exr").read_bytes()
    with pytest.raises(ValueError, match=r".+"):
        chunk_hash(io.BytesIO(data[:short]))


def test_bands_of_rows_do_not_matter() -> None:
    pixels = np.random.default_rng(0).random((70, 5, 3), np.float32)
    bands = DecodedHash(5, 70, 3)
    for start in range(0, 70, 32):
        bands.update(pixels[start : start + 32])
    assert bands.hexdigest() == decoded_hash(pixels)
    assert decoded_hash(pixels) != decoded_hash(pixels.reshape(35, 10, 3))
