"""Depth, normals, motion and ids are found in the files of each renderer, with the numbers that OpenEXR gives."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flowabs_nodes.errors import CommandError, ReadError
from flowabs_nodes.io.read_passes import read_depth, read_id, read_motion, read_normal
from flowabs_nodes.io.settings import Settings
from tests.io import renders
from tests.io.files import box, colors, exr, native, parts, planes, same_bits

BLENDER = (renders.blender45, renders.blender5)
ALL = (*BLENDER, renders.arnold, renders.renderman, renders.vray, renders.karma)


def channel(path: Path, name: str) -> np.ndarray:
    """Return a channel by its whole name as OpenEXR reads it, in whichever part it is."""
    for part in range(20):
        found = native(path, part)
        if name in found:
            return found[name]
    raise KeyError(name)


# ---------------------------------------------------------------------- each renderer's names


@pytest.mark.parametrize("render", ALL)
def test_depth(tmp_path: Path, render: Any) -> None:
    notes: list[str] = []
    image = read_depth(render(tmp_path / "a.exr"), note=notes.append, warn=pytest.fail)
    assert image.type == "depth"
    assert same_bits(image.pixels[..., 0], renders.depth())
    assert any("is read" in note for note in notes)
    assert f"{12 * 24} pixels are background: depth 1e+10" in notes


@pytest.mark.parametrize("render", ALL)
def test_normals(tmp_path: Path, render: Any) -> None:
    image = read_normal(render(tmp_path / "a.exr"), warn=pytest.fail)
    assert image.type == "normal"
    assert same_bits(image.pixels, renders.NORMAL)


@pytest.mark.parametrize("render", BLENDER)
def test_blenders_motion_is_kept_as_it_is(tmp_path: Path, render: Any) -> None:
    image = read_motion(render(tmp_path / "a.exr"))
    assert image.type == "motion"
    assert same_bits(image.pixels, renders.VECTOR)
    assert image.origin is not None
    assert image.origin.channels == tuple(f"ViewLayer.Vector.{each}" for each in "XYZW")


@pytest.mark.parametrize("render", [renders.arnold, renders.vray, renders.karma])
def test_motion_to_the_next_frame(tmp_path: Path, render: Any) -> None:
    """(x + u, y + v) is the next place, so -Z, -W lead there, and X, Y the opposite way."""
    u, v = renders.VECTOR[..., 0], renders.VECTOR[..., 1]
    notes: list[str] = []
    image = read_motion(render(tmp_path / "a.exr"), note=notes.append)
    np.testing.assert_array_equal(image.pixels, np.stack([-u, -v, -u, -v], axis=2))
    assert "as forward" in notes[0]


def test_motion_both_ways_in_two_layers(tmp_path: Path) -> None:
    image = read_motion(renders.renderman(tmp_path / "a.exr"))
    back, fore = renders.VECTOR[..., :2], renders.VECTOR[..., 2:]
    np.testing.assert_array_equal(image.pixels, np.concatenate([back, -fore], axis=2))


def test_both_conventions_mean_the_same_steady_motion(tmp_path: Path) -> None:
    """A thing that moves by (3, 2) a frame, y up, was at (-3, -2) and comes to (3, 2)."""
    steady = np.zeros((24, 32, 2), np.float32) + np.float32([3, 2])
    blender = np.concatenate([-steady, -steady], axis=2)
    path = exr(
        tmp_path / "a.exr",
        planes(blender, "XYZW", "Vector") | planes(steady, "uv", "fore.a") | planes(-steady, "uv", "back.a"),
    )
    for options in ({}, {"layer": "fore.a"}, {"layer": "back.a", "convention": "backward"}):
        np.testing.assert_array_equal(read_motion(path, **options).pixels, blender)


def test_the_convention_can_be_said(tmp_path: Path) -> None:
    path = renders.blender5(tmp_path / "a.exr")
    u, v = renders.VECTOR[..., 0], renders.VECTOR[..., 1]
    forward = read_motion(path, convention="forward").pixels
    np.testing.assert_array_equal(forward, np.stack([-u, -v, -u, -v], axis=2))
    with pytest.raises(ReadError, match="no layer with a usual name for motion"):
        read_motion(renders.arnold(tmp_path / "b.exr"), convention="blender")


@pytest.mark.parametrize("render", [*BLENDER, renders.arnold])
def test_a_cryptomatte(tmp_path: Path, render: Any) -> None:
    ids, coverage = read_id(render(tmp_path / "a.exr"))
    assert (ids.type, coverage.type) == ("id", "mono")
    expected = np.zeros((24, 32), np.uint32)
    expected[:, :9], expected[:, 9:20] = renders.CRATE, renders.BALL
    assert same_bits(ids.pixels[..., 0], expected)
    np.testing.assert_allclose(coverage.pixels[0, [0, 9, 20], 0], [0.7, 0.4, 0.4], rtol=1e-6)
    assert ids.spec.getattribute("cryptomatte/abc1234/manifest") == renders.MANIFEST


@pytest.mark.parametrize(
    ("render", "layer", "expected"),
    [
        (renders.blender45, "IndexOB", renders.INDEX),
        (renders.blender45, "ViewLayer.IndexOB.X", renders.INDEX),
        (renders.blender5, "ViewLayer.Object Index", renders.INDEX),
        (renders.arnold, "ID", renders.ARNOLD_IDS),
        (renders.renderman, "", renders.INDEX),
        (renders.vray, "", renders.INDEX),
    ],
)
def test_an_id_pass(tmp_path: Path, render: Any, layer: str, expected: np.ndarray) -> None:
    ids, coverage = read_id(render(tmp_path / "a.exr"), layer=layer)
    assert same_bits(ids.pixels[..., 0], expected.astype(np.uint32))
    assert (coverage.pixels == 1).all()


def test_minus_one_is_an_id_of_its_own(tmp_path: Path) -> None:
    ids, _ = read_id(renders.karma(tmp_path / "a.exr"))
    assert same_bits(ids.pixels[..., 0], (renders.INDEX.astype(np.int64) - 1).astype(np.uint32))
    assert ids.pixels.max() == 2**32 - 1


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.uint32])
def test_an_id_pass_of_any_type(tmp_path: Path, dtype: Any) -> None:
    ids, _ = read_id(exr(tmp_path / "a.exr", {"id": renders.INDEX.astype(dtype)}))
    assert same_bits(ids.pixels[..., 0], renders.INDEX.astype(np.uint32))


def test_a_cryptomatte_of_any_name_is_known_by_its_header(tmp_path: Path) -> None:
    channels = {name: plane for level in renders.crypto_planes("mine").values() for name, plane in level.items()}
    path = exr(tmp_path / "a.exr", planes(colors()) | channels, **renders.crypto_header("mine"))
    assert read_id(path)[0].pixels[0, 0, 0] == renders.CRATE
    for layer in ("mine", "mine00", "mine01"):
        assert read_id(path, layer=layer)[0].pixels[0, 9, 0] == renders.BALL


def test_another_cryptomatte_of_the_file(tmp_path: Path) -> None:
    path = renders.blender5(tmp_path / "a.exr")
    for layer in ("CryptoMaterial", "ViewLayer.CryptoMaterial", "ViewLayer.CryptoMaterial00"):
        ids, _ = read_id(path, layer=layer)
        assert ids.origin is not None
        assert ids.origin.layer == "ViewLayer.CryptoMaterial00"


# ---------------------------------------------------------------------- what stands for nothing


def test_all_backgrounds_become_1e10(tmp_path: Path) -> None:
    z = np.array([[1, 9.99e9, 1e10, 1e30, 3e38, np.inf, -np.inf, -5]], np.float32)
    notes: list[str] = []
    image = read_depth(exr(tmp_path / "a.exr", {"Z": z}), note=notes.append, warn=pytest.fail)
    expected = np.array([1, 9.99e9, *[1e10] * 5, -5], np.float32)
    assert same_bits(image.pixels[0, :, 0], expected)
    assert "5 pixels are background: depth 1e+10" in notes


def test_in_half_the_largest_number_is_background(tmp_path: Path) -> None:
    z = np.array([[1, 65472, 65504, np.inf]], np.float16)
    image = read_depth(exr(tmp_path / "a.exr", {"Z": z}))
    np.testing.assert_array_equal(image.pixels[0, :, 0], np.array([1, 65472, 1e10, 1e10], np.float32))
    float_too = read_depth(exr(tmp_path / "b.exr", {"Z": np.array([[65504.0]], np.float32)}))
    assert float_too.pixels[0, 0, 0] == 65504


def test_nan_in_a_pass_is_told(tmp_path: Path) -> None:
    bad = np.array([[1, np.nan]], np.float32)
    warned: list[str] = []
    assert read_depth(exr(tmp_path / "a.exr", {"Z": bad}), warn=warned.append).pixels[0, 1, 0] == 1e10
    normals = planes(np.stack([bad, bad, bad], 2), "XYZ", "N")
    assert (read_normal(exr(tmp_path / "b.exr", normals), warn=warned.append).pixels[0, 1] == 0).all()
    assert warned == ["1 NaN in the depth count as background", "1 normals with NaN or Inf become 0, 0, 0"]


def test_vectors_of_no_surface_are_0_each_way_for_itself(tmp_path: Path) -> None:
    vector = np.ones((1, 4, 4), np.float32)
    vector[0, 1] = 4e5
    vector[0, 2, 2] = np.nan
    vector[0, 3, 1] = 299999
    notes: list[str] = []
    image = read_motion(exr(tmp_path / "a.exr", planes(vector, "XYZW", "V.Vector")), note=notes.append)
    np.testing.assert_array_equal(image.pixels[0], [[1, 1, 1, 1], [0, 0, 0, 0], [1, 1, 0, 0], [1, 299999, 1, 1]])
    assert "2 pixels have no surface that could move: their motion is 0" in notes


def test_in_half_the_largest_vector_is_none(tmp_path: Path) -> None:
    vector = np.array([[[65504, 1, 1, 1]]], np.float16)
    image = read_motion(exr(tmp_path / "a.exr", planes(vector, "XYZW", "V.Vector")))
    np.testing.assert_array_equal(image.pixels[0, 0], [0, 0, 1, 1])


# ---------------------------------------------------------------------- mistakes


def test_a_missing_pass_lists_what_there_is_with_the_nearest(tmp_path: Path) -> None:
    path = exr(tmp_path / "a.exr", planes(colors()) | {"deph": renders.depth()})
    with pytest.raises(
        ReadError, match=r"usual name for depth \(depth, z, zdepth, pz\); it has .*deph.*layer: 'deph'"
    ) as caught:
        read_depth(path)
    assert caught.value.code == "no-layer"
    assert caught.value.file == str(path)
    with pytest.raises(ReadError, match=r"'dept' is not in the file; it has .*did you mean 'deph'"):
        read_depth(path, layer="dept")


@pytest.mark.parametrize("render", BLENDER)
@pytest.mark.parametrize("read", [read_depth, read_normal, read_motion, read_id])
def test_two_view_layers_are_ambiguous(tmp_path: Path, render: Any, read: Any) -> None:
    path = render(tmp_path / "a.exr", "Near", "Far")
    with pytest.raises(ReadError, match=r"could be read from several places: layers .*Near\..*layer: 'Far\.") as caught:
        read(path)
    assert caught.value.code == "ambiguous-layer"
    name = {read_depth: "Depth", read_normal: "Normal", read_motion: "Vector", read_id: "CryptoObject"}[read]
    found = read(path, layer=f"Far.{name}")
    image = found[0] if isinstance(found, tuple) else found
    assert image.origin.layer.startswith(f"Far.{name}")


def test_one_layer_in_two_parts_is_ambiguous(tmp_path: Path) -> None:
    path = parts(tmp_path / "a.exr", ("left", {"Z": renders.depth()}, {}), ("right", {"Z": renders.depth() + 1}, {}))
    with pytest.raises(ReadError, match=r"layer 'Z' in the parts left, right .*part: 'left' or part: 'right'"):
        read_depth(path)
    np.testing.assert_array_equal(read_depth(path, part="right").pixels[0, 0, 0], renders.depth()[0, 0] + 1)


def test_a_layer_that_is_something_else(tmp_path: Path) -> None:
    path = renders.arnold(tmp_path / "a.exr")
    with pytest.raises(
        ReadError, match=r"'N' has the channels N\.X, N\.Y, N\.Z; expected for depth: one channel"
    ) as caught:
        read_depth(path, layer="N")
    assert caught.value.code == "wrong-layer"
    with pytest.raises(ReadError, match="expected for normals: X, Y, Z"):
        read_normal(path, layer="Z")


def test_a_colour_is_no_depth(tmp_path: Path) -> None:
    path = exr(tmp_path / "a.exr", planes(colors(), layer="diffuse"))
    with pytest.raises(ReadError, match="no single number"):
        read_depth(path, layer="diffuse")


@pytest.mark.parametrize("wrong", [0.5, np.nan, np.inf, 2.0**33])
def test_numbers_that_are_no_ids(tmp_path: Path, wrong: float) -> None:
    path = exr(tmp_path / "a.exr", {"id": np.array([[1, wrong]], np.float32)})
    with pytest.raises(ReadError, match=r"1 of the numbers .*read_aov"):
        read_id(path)


def test_a_cryptomatte_in_half_has_lost_its_ids(tmp_path: Path) -> None:
    channels = {f"CryptoObject00.{each}": np.ones((2, 3), np.float16) for each in "rgba"}
    with pytest.raises(ReadError, match="32-bit floats"):
        read_id(exr(tmp_path / "a.exr", channels))


def test_limits_and_root_of_the_run(tmp_path: Path) -> None:
    path = renders.arnold(tmp_path / "a.exr")
    for read in (read_depth, read_normal, read_motion, read_id):
        with pytest.raises(ReadError, match="more than 100 pixels"):
            read(path, settings=Settings(max_pixels=100))
        with pytest.raises(CommandError):
            read(path, settings=Settings(root=str(tmp_path / "elsewhere")))


def test_windows_and_metadata_come_along(tmp_path: Path) -> None:
    path = exr(
        tmp_path / "a.exr",
        {"Z": renders.depth()},
        dataWindow=box(3, -2, 32, 24),
        displayWindow=box(0, 0, 40, 30),
        owner="me",
    )
    image = read_depth(path)
    assert image.data_window == (3, -2, 32, 24)
    assert image.display_window == (0, 0, 40, 30)
    assert image.spec.getattribute("Copyright") == "me"
