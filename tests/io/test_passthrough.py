"""Which of the plate's other layers are kept, and an alpha that was not read. Bit for bit: test_fidelity.py."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import pytest

from flowabs_nodes.engine.resize import scale_image
from flowabs_nodes.errors import ReadError, WriteError
from flowabs_nodes.image import Image, Window
from flowabs_nodes.io.passthrough import layers_left_out
from flowabs_nodes.io.read import read_data, read_image
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.io.write import build_picture, save
from tests.io.files import (
    attributes,
    box,
    colors,
    exr,
    flat,
    like,
    native,
    parts,
    planes,
    same_bits,
    windowed,
    written,
)

RNG = np.random.default_rng(3)


def aovs(height: int = 24, width: int = 32) -> dict[str, Any]:
    """Return half, float and uint channels side by side, with every bit pattern that may occur."""
    shape = (height, width)
    bits = RNG.integers(0, 2**32, shape, dtype=np.uint32)
    return {
        "Z": RNG.random(shape, np.float32) * 1e30,
        "N.X": RNG.random(shape).astype(np.float16),
        "N.Y": RNG.random(shape).astype(np.float16),
        "id": bits,
        "crypto00.red": bits.view(np.float32),  # ids as floats: NaN and denormals among them
        "crypto00.green": RNG.random(shape, np.float32),
        "diffuse.R": RNG.random(shape).astype(np.float16),
    }


@pytest.fixture
def plate(tmp_path: Path) -> Path:
    header = {"cryptomatte/abc/manifest": '{"bunny":"deadbeef"}', "displayWindow": box(-3, 0, 40, 30)}
    return exr(tmp_path / "plate.exr", planes(colors(channels=4)) | aovs(), **header)


def kept(image: Image, path: Path, names: str, **layers: Image) -> tuple[dict[str, np.ndarray], list[str]]:
    """Write an image with these layers of its plate kept; return the file's channels, and the warnings."""
    warned: list[str] = []
    save(build_picture(image, layers, keep_layers=names, warn=warned.append), path, warn=warned.append)
    return native(path), warned


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        ("", set()),
        ("Z", {"Z"}),
        ("N, id", {"N.X", "N.Y", "id"}),
        ("crypto*", {"crypto00.red", "crypto00.green"}),
    ],
)
def test_by_name(tmp_path: Path, plate: Path, names: str, expected: set[str]) -> None:
    found, _ = kept(read_image(plate), tmp_path / "out.exr", names)
    assert set(found) - set("RGBA") == expected


def test_a_name_that_is_not_there(tmp_path: Path, plate: Path) -> None:
    with pytest.raises(WriteError, match="did you mean 'diffuse'") as caught:
        kept(read_image(plate), tmp_path / "out.exr", "difuse")
    assert (caught.value.code, caught.value.parameter) == ("no-layer", "keep_layers")
    assert not list(tmp_path.glob("*out*"))


def test_a_name_that_is_no_utf8_is_taken_for_latin_1(tmp_path: Path) -> None:
    plate = exr(tmp_path / "plate.exr", planes(colors()) | {"lumi?re.Z": aovs()["Z"]})
    plate.write_bytes(plate.read_bytes().replace(b"lumi?re.Z", b"lumi\xe8re.Z"))
    found, _ = kept(read_image(plate), tmp_path / "out.exr", "*")
    assert set(found) == {*"RGB", "lumière.Z"}


def test_a_new_layer_wins(tmp_path: Path, plate: Path) -> None:
    image = read_image(plate)
    mine = image.with_pixels(np.full((24, 32, 1), 0.5, np.float32), "matte")
    found, _ = kept(image, tmp_path / "out.exr", "*", diffuse=mine, Z=mine)
    assert "diffuse.R" not in found
    assert "Z" not in found
    np.testing.assert_array_equal(found["diffuse.Y"], np.float16(0.5))


def test_the_layer_that_was_read_is_no_other_layer(tmp_path: Path) -> None:
    combined = planes(colors(channels=4), layer="ViewLayer.Combined")
    plate = exr(tmp_path / "blender.exr", combined | {"ViewLayer.Depth.Z": np.ones((24, 32), np.float32)})
    found, _ = kept(read_image(plate), tmp_path / "out.exr", "*")
    assert set(found) == {"R", "G", "B", "A", "ViewLayer.Depth.Z"}
    found, _ = kept(read_image(plate), tmp_path / "out.exr", "ViewLayer.Combined")
    assert {"R", "ViewLayer.Combined.R"} < set(found)


def test_other_parts_follow(tmp_path: Path) -> None:
    small = {"dataWindow": box(2, 3, 16, 12), "displayWindow": box(0, 0, 40, 30), "owner": "depth"}
    full = {"dataWindow": box(0, 0, 32, 24), "displayWindow": box(0, 0, 40, 30)}
    plate = parts(
        tmp_path / "parts.exr",
        ("depth_left", {"Z": aovs(12, 16)["Z"]}, small | {"compression": OpenEXR.ZIPS_COMPRESSION}),
        ("rgba_right", planes(colors(channels=4)) | {"id": aovs()["id"]}, full | {"view": "right"}),
        (
            "rgba_left",
            planes(colors(channels=4, seed=2)),
            full | {"view": "left", "compression": OpenEXR.DWAA_COMPRESSION},
        ),
    )
    out = tmp_path / "out.exr"
    _, warned = kept(read_image(plate), out, "*")
    names = [part.name() for part in OpenEXR.File(str(out), header_only=True).parts]
    assert names == ["rgba_right", "depth_left", "rgba_left"]
    for new, old in ((0, 1), (1, 0), (2, 2)):
        before, after = native(plate, old), native(out, new)
        assert set(before) == set(after)
        assert all(same_bits(before[name], after[name]) for name in before)
        assert attributes(out, new) == attributes(plate, old)
    assert not warned
    _, _ = kept(read_image(plate), out, "depth_left")
    assert [part.name() for part in OpenEXR.File(str(out), header_only=True).parts] == ["rgba_right", "depth_left"]


def test_on_another_data_window_they_are_cut(tmp_path: Path, plate: Path) -> None:
    found, warned = kept(read_image(plate).on_window(Window(1, 2, 10, 8)), tmp_path / "out.exr", "id")
    assert same_bits(found["id"], native(plate)["id"][2:10, 1:11].copy())
    assert "data window" in warned[0]


def test_at_another_size_they_are_left_out(tmp_path: Path, plate: Path) -> None:
    image = read_image(plate)
    spec = image.spec
    spec.width, spec.height, spec.full_width, spec.full_height = 16, 12, 20, 15
    small = Image(image.pixels[::2, ::2], spec, "color", origin=image.origin)
    found, warned = kept(small, tmp_path / "out.exr", "*")
    assert set(found) == set("RGBA")
    assert "size" in warned[0]


def test_nothing_to_keep_from(tmp_path: Path) -> None:
    for image in (Image.from_array(colors()), read_image(flat(tmp_path / "a.png", np.zeros((4, 4, 3), np.uint8)))):
        _, warned = kept(image, tmp_path / "out.exr", "*")
        assert "does not come from an EXR" in warned[0]


# ---------------------------------------------------------------------- an alpha that was not read


def test_an_alpha_of_zero_everywhere_is_written_as_it_was(tmp_path: Path) -> None:
    pixels = colors(channels=4)
    pixels[..., 3] = 0
    plate = exr(tmp_path / "carrots.exr", planes(pixels))
    image = read_image(plate)
    out, _ = written(like(image, image.pixels + 1), tmp_path / "out.exr", layers={"n": image})
    found = native(out)
    assert same_bits(found["A"], native(plate)["A"])
    assert "n.A" not in found
    assert "A" not in native(written(like(image, image.pixels[..., :1], "matte"), tmp_path / "m.exr")[0])


def test_an_ignored_alpha_is_written_as_it_was(tmp_path: Path) -> None:
    plate = windowed(tmp_path / "plate.exr")
    channels: dict[str, np.ndarray] = native(plate) | {"A": colors()[..., 0].astype(np.float32)}
    header = {
        name: value for name, value in OpenEXR.File(str(plate), header_only=True).header().items() if "Window" in name
    }
    plate = exr(tmp_path / "alpha.exr", channels, **header)
    image = read_image(plate, alpha="ignore")
    out, _ = written(image, tmp_path / "out.exr")
    assert same_bits(native(out)["A"], channels["A"])
    moved = image.on_window(Window(0, 0, 10, 10))
    out, _ = written(moved, tmp_path / "moved.exr")
    placed = np.zeros((10, 10), np.float32)
    placed[:, 3:] = channels["A"][2:12, :7]  # the corner of the plate's window is (3, -2), of the new one (0, 0)
    np.testing.assert_array_equal(native(out)["A"], placed)


def test_a_plate_that_is_gone_takes_nothing_with_it_silently(tmp_path: Path) -> None:
    pixels = colors(channels=4)
    plate = exr(tmp_path / "plate.exr", planes(pixels))
    ignored, image = read_image(plate, alpha="ignore"), read_image(plate)
    plate.unlink()
    for lost, options in ((ignored, {}), (image, {"keep_layers": "*"})):
        with pytest.raises(ReadError, match="no such file"):
            written(lost, tmp_path / "out.exr", **options)
    assert not (tmp_path / "out.exr").exists()
    _, warned = written(image, tmp_path / "out.exr")
    assert "word for word" in warned[0]


@pytest.mark.parametrize("suffix", [".png", ".tif"])
@pytest.mark.parametrize(
    ("dtype", "stored"), [(np.uint8, np.float16), (np.uint16, np.float32), (np.float32, np.float32)]
)
@pytest.mark.parametrize("empty", [False, True])
def test_a_photographs_alpha_becomes_0_to_1(tmp_path: Path, suffix: str, dtype: Any, stored: Any, empty: bool) -> None:
    if dtype == np.float32 and suffix == ".png":
        return
    largest = np.iinfo(dtype).max if dtype != np.float32 else 1
    pixels = (np.clip(colors(channels=4, dtype=np.float64) / 2, 0, 1) * largest).astype(dtype)
    pixels[..., 3] *= not empty
    image = read_image(flat(tmp_path / f"a{suffix}", pixels), alpha="auto" if empty else "ignore")
    out, warned = written(image, tmp_path / "out.exr")
    found = native(out)["A"]
    assert found.dtype == stored
    if dtype == np.float32:
        np.testing.assert_array_equal(found, pixels[..., 3])
    else:
        np.testing.assert_array_equal(np.rint(found.astype(np.float64) * largest), pixels[..., 3])
    assert not warned


@pytest.mark.parametrize("orientation", range(1, 9))
def test_a_left_out_alpha_is_turned_with_the_picture(tmp_path: Path, orientation: int) -> None:
    pixels = np.arange(6 * 4 * 4, dtype=np.uint8).reshape(6, 4, 4)
    pixels[..., 3] = pixels[..., 0]
    plate = flat(tmp_path / "a.tif", pixels, Orientation=orientation)
    out, warned = written(read_image(plate, alpha="ignore"), tmp_path / "out.exr")
    kept = written(read_image(plate), tmp_path / "kept.exr")[0]
    np.testing.assert_array_equal(native(out)["A"], native(kept)["A"])
    assert not warned


# ---------------------------------------------------------------------- what is left out


def test_layers_that_are_left_out_are_those_that_could_be_kept(plate: Path) -> None:
    image = read_image(plate)
    left_out = layers_left_out(image, {}, Settings())
    assert set(left_out) == {"Z", "N", "id", "crypto00", "diffuse"}
    assert "diffuse" not in layers_left_out(image, {"diffuse": image}, Settings()), "a layer of the frame replaces it"
    depth = read_data(plate, layer="Z")
    assert "Z" not in layers_left_out(image, {"depth": depth}, Settings()), "it is there under another name"
    assert layers_left_out(Image.from_array(np.zeros((2, 2, 3), np.float32)), {}, Settings()) == ()
    assert layers_left_out(scale_image(image, 0.5), {}, Settings()) == (), "of another size they cannot be kept"
    plate.unlink()
    assert layers_left_out(image, {}, Settings()) == ()
