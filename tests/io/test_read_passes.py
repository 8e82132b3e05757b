"""Depth and normals are found in the files of each renderer, with the numbers that OpenEXR gives; so are mistakes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flowabs_nodes.errors import CommandError, ReadError
from flowabs_nodes.io.read_id import read_id
from flowabs_nodes.io.read_motion import read_motion
from flowabs_nodes.io.read_passes import read_depth, read_normal
from flowabs_nodes.io.settings import Settings
from tests.io import renders
from tests.io.files import box, colors, exr, parts, planes, same_bits

BLENDER = (renders.blender45, renders.blender5)
ALL = (*BLENDER, renders.arnold, renders.renderman, renders.vray, renders.karma)


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
    of_a_layer = exr(tmp_path / "b.exr", {"ViewLayer.Depth.Z": renders.depth(), "ViewLayer.Mist.Z": renders.depth()})
    with pytest.raises(ReadError, match=r"it has ViewLayer.Depth.Z, ViewLayer.Mist.Z \(did you mean 'Depth'"):
        read_depth(of_a_layer, layer="depht")


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
