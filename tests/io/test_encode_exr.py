"""What goes into an EXR: layers, data types, NaN and overflow, compression. What stays as it was: test_fidelity.py."""

from __future__ import annotations

import gc
import weakref
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import OpenImageIO as oiio
import pytest

from flowabs_nodes.encodings import remember_encodings
from flowabs_nodes.errors import WriteError
from flowabs_nodes.image import Image
from flowabs_nodes.io.read import read_data, read_image
from flowabs_nodes.testing.pictures import make_input
from tests.io.files import (
    box,
    colors,
    exr,
    flat,
    like,
    native,
    planes,
    same_bits,
    windowed,
    written,
)

AP0 = (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767)


# ---------------------------------------------------------------------- channels and data types


def test_decoded_pixels_are_let_go_where_nobody_else_wants_them(tmp_path: Path) -> None:
    plain = make_input("color", "noise", 24, 32)
    with remember_encodings() as encodings:
        image = plain.with_codes(plain.encoded("lab"), "lab")
        encodings.keep(image, False)
        decoded = weakref.ref(image.pixels)
        written(image, tmp_path / "out.exr")
        gc.collect()
        assert decoded() is None


def test_layers(tmp_path: Path) -> None:
    image = read_image(windowed(tmp_path / "plate.exr"))
    one = np.linspace(0, 1, 24 * 32, dtype=np.float32).reshape(24, 32, 1)
    data = exr(tmp_path / "d.exr", {"forward.u": one[..., 0], "forward.v": one[..., 0]}, dataWindow=box(3, -2, 32, 24))
    out, warned = written(
        like(image, one, "matte"),
        tmp_path / "out.exr",
        layers={
            "ink": like(image, colors(channels=4), "color"),
            "lines": like(image, one, "matte"),
            "lic": like(image, one, "mono"),
            "etf": like(image, np.repeat(one, 2, 2), "flow"),
            "motion": read_data(data),
        },
    )
    found = native(out)
    assert {name: str(plane.dtype) for name, plane in found.items()} == {
        **dict.fromkeys(("R", "G", "B", "ink.R", "ink.G", "ink.B", "ink.A", "lines.Y", "lic.Y"), "float16"),
        **dict.fromkeys(("etf.x", "etf.y", "motion.u", "motion.v"), "float32"),
    }
    for name in ("R", "G", "B", "lines.Y", "lic.Y"):
        np.testing.assert_array_equal(found[name], one[..., 0].astype(np.float16))
    assert same_bits(found["motion.u"], one[..., 0])
    assert not warned


def test_a_flow_as_the_main_image(tmp_path: Path) -> None:
    image = read_image(windowed(tmp_path / "plate.exr"))
    out, _ = written(like(image, colors(channels=3)[..., :2], "flow"), tmp_path / "out.exr")
    found = native(out)
    assert set(found) == {"flow.x", "flow.y"}
    assert found["flow.x"].dtype == np.float32


def test_two_of_one_name_are_refused(tmp_path: Path) -> None:
    flow = like(read_image(windowed(tmp_path / "plate.exr")), colors()[..., :2], "flow")
    with pytest.raises(WriteError, match=r"flow\.x would be both"):
        written(flow, tmp_path / "out.exr", layers={"flow": flow})


def test_data_channels_of_one_last_name_keep_all_of_theirs(tmp_path: Path) -> None:
    plane = np.zeros((24, 32), np.float32)
    path = exr(tmp_path / "d.exr", {"f.left.u": plane, "f.right.u": plane + 1})
    image = read_image(exr(tmp_path / "p.exr", planes(colors())))
    out, _ = written(image, tmp_path / "out.exr", layers={"n": read_data(path, layer="f")})
    assert {"n.f.left.u", "n.f.right.u"} < set(native(out))


def test_layers_on_another_window_are_cut_to_the_image(tmp_path: Path) -> None:
    image = read_image(windowed(tmp_path / "plate.exr"))
    other = Image.from_array(np.ones((24, 32), np.float32), type="matte")
    out, warned = written(image, tmp_path / "out.exr", layers={"n": other})
    assert "data window" in warned[0]
    np.testing.assert_array_equal(native(out)["n.Y"][2:, :29], 1)
    np.testing.assert_array_equal(native(out)["n.Y"][:2], 0)


@pytest.mark.parametrize(
    ("plate", "data_type", "expected"),
    [
        (np.float16, "auto", np.float16),
        (np.float32, "auto", np.float32),
        (np.float16, "float", np.float32),
        (np.float32, "half", np.float16),
    ],
)
def test_data_type(tmp_path: Path, plate: Any, data_type: str, expected: Any) -> None:
    image = read_image(exr(tmp_path / "plate.exr", planes(colors(dtype=plate))))
    out, warned = written(image, tmp_path / "out.exr", data_type=data_type, layers={"l": like(image, image.pixels)})
    assert {plane.dtype for plane in native(out).values()} == {np.dtype(expected)}
    assert not warned


def test_photographs_become_half_and_say_what_they_are(tmp_path: Path) -> None:
    image = read_image(flat(tmp_path / "a.png", (colors() * 100).astype(np.uint8), Copyright="me", XResolution=72.0))
    out, warned = written(image, tmp_path / "out.exr", data_type="uint8")
    assert native(out)["R"].dtype == np.float16
    assert "EXR cannot hold uint8" in warned[0]
    header = OpenEXR.File(str(out), header_only=True).header()
    assert header["colorInteropID"] == "lin_rec709_scene"
    assert header["owner"] == "me"
    assert OpenEXR.checkColorMetadata(header) == 0
    assert "xDensity" not in header


def test_overflow_is_clamped_and_counted(tmp_path: Path) -> None:
    pixels = np.array([[[65504, 65505, -1e9], [np.nan, np.inf, 1]]], np.float32)
    out, warned = written(Image.from_array(pixels), tmp_path / "out.exr")
    found = native(out)
    np.testing.assert_array_equal(found["R"], np.array([[65504, 0]], np.float16))
    np.testing.assert_array_equal(found["G"], np.array([[65504, 65504]], np.float16))
    np.testing.assert_array_equal(found["B"], np.array([[-65504, 1]], np.float16))
    assert warned == ["image: 1 NaN written as 0", "image: 3 values beyond half clamped to ±65504"]


def test_data_layers_keep_nan_and_inf_and_say_so(tmp_path: Path) -> None:
    depth = np.array([[np.inf, np.nan, 1e9]], np.float32)
    data = read_data(exr(tmp_path / "z.exr", {"Z": depth}))
    image = Image.from_array(np.ones((1, 3, 3), np.float32))
    out, warned = written(image, tmp_path / "a.exr", layers={"depth": data})
    assert same_bits(native(out)["depth.Z"], depth)
    assert warned == ["depth: 1 NaN and 1 Inf written as they are"]
    out, warned = written(image, tmp_path / "b.exr", layers={"depth": data}, data_type="half")
    np.testing.assert_array_equal(native(out)["depth.Z"], np.array([[np.inf, np.nan, 65504]], np.float16))
    assert "clamped" in warned[1]


@pytest.mark.parametrize("data_type", ["auto", "half", "float"])
def test_passes_are_written_bit_for_bit_whatever_is_asked_for(tmp_path: Path, data_type: str) -> None:
    image = read_image(windowed(tmp_path / "plate.exr"))
    layers = {kind: make_input(kind, "noise", 24, 32) for kind in ("depth", "normal", "motion", "id")}
    placed = {kind: Image(each.pixels, _with_windows(each, image), kind) for kind, each in layers.items()}
    out, warned = written(image, tmp_path / "out.exr", data_type=data_type, layers=placed)
    found = native(out)
    expected = {
        "depth.Z": layers["depth"].pixels[..., 0],
        "id.id": layers["id"].pixels[..., 0],
        **{f"normal.{each}": layers["normal"].pixels[..., i] for i, each in enumerate("XYZ")},
        **{f"motion.{each}": layers["motion"].pixels[..., i] for i, each in enumerate("XYZW")},
    }
    assert set(found) == {"R", "G", "B", *expected}
    assert all(same_bits(found[name], plane) for name, plane in expected.items())
    assert (found["id.id"] > 2**24).any()
    assert not warned


def _with_windows(image: Image, like: Image) -> oiio.ImageSpec:
    """Return an image's header on the windows of another."""
    spec = image.spec
    spec.x, spec.y = like.data_window[:2]
    spec.full_x, spec.full_y, spec.full_width, spec.full_height = like.display_window
    return spec


@pytest.mark.parametrize("kind", ["depth", "normal", "motion", "id"])
def test_a_pass_as_the_main_image(tmp_path: Path, kind: str) -> None:
    image = make_input(kind, "noise", 24, 32)
    plain = Image(image.pixels, image.spec, kind)
    out, warned = written(plain, tmp_path / "out.exr", data_type="half")
    found = native(out)
    assert list(found) == sorted(image.channels)
    assert all(same_bits(found[name], image.pixels[..., i]) for i, name in enumerate(image.channels))
    assert not warned


def test_nan_in_a_pass_stays_and_is_told(tmp_path: Path) -> None:
    depth = Image.from_array(np.array([[1, np.nan, np.inf]], np.float32), type="depth")
    out, warned = written(depth, tmp_path / "out.exr")
    assert same_bits(native(out)["Z"], depth.pixels[..., 0])
    assert warned == ["image: 1 NaN and 1 Inf written as they are"]


# ---------------------------------------------------------------------- compression


def test_lossy_compression_is_for_those_who_ask(tmp_path: Path) -> None:
    image = read_image(windowed(tmp_path / "plate.exr"))
    for compression in ("dwaa", "dwab", "b44", "b44a"):
        out, warned = written(image, tmp_path / "out.exr", compression=compression)
        assert oiio.ImageInput.open(str(out)).spec().get_string_attribute("compression").startswith(compression)
        assert "changes the picture" in warned[0]
    _, warned = written(image, tmp_path / "out.exr", compression="piz")
    assert not warned


def test_dwa_changes_data_layers_too(tmp_path: Path) -> None:
    """It takes N.Y for luma: a warning says that data are changed, and "auto" never writes it."""
    noise = np.random.default_rng(1).random((64, 64)).astype(np.float16)
    data = read_data(exr(tmp_path / "n.exr", {f"N.{axis}": noise for axis in "XYZ"}))
    image = read_image(exr(tmp_path / "plate.exr", planes(colors(64, 64))))
    out, warned = written(image, tmp_path / "dwaa.exr", compression="dwaa", layers={"N": data}, data_type="half")
    assert not same_bits(native(out)["N.Y"], noise)
    assert "data layers too" in warned[0]
    out, _ = written(image, tmp_path / "auto.exr", layers={"N": data})
    assert same_bits(native(out)["N.Y"], noise)


# ---------------------------------------------------------------------- alpha and colour
