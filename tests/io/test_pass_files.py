"""Passes that have a file of their own, under whatever name; and what is taken for none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flowabs_nodes.errors import ReadError
from flowabs_nodes.io.read_id import read_id
from flowabs_nodes.io.read_motion import read_motion
from flowabs_nodes.io.read_passes import read_depth, read_normal
from tests.io import renders
from tests.io.files import Planes, colors, exr, parts, planes, same_bits

NORMALS = renders.NORMAL / np.linalg.norm(renders.NORMAL, axis=2, keepdims=True)
GREY_DEPTH = np.repeat(renders.depth()[..., None], 3, axis=2)


@pytest.mark.parametrize("channels", [{"Y": renders.depth()}, {"V": renders.depth()}, planes(GREY_DEPTH)])
def test_depth(tmp_path: Path, channels: Planes) -> None:
    notes: list[str] = []
    image = read_depth(exr(tmp_path / "depth.exr", channels), note=notes.append)
    assert same_bits(image.pixels[..., 0], renders.depth())
    assert notes[0] == f"the file's only layer, {', '.join(channels)}, is read"


@pytest.mark.parametrize("names", ["RGB", "XYZ", "xyz"])
def test_normals(tmp_path: Path, names: str) -> None:
    assert same_bits(read_normal(exr(tmp_path / "n.exr", planes(NORMALS, names))).pixels, NORMALS)


def test_normals_in_a_part_with_a_name(tmp_path: Path) -> None:
    path = parts(tmp_path / "n.exr", ("anything", planes(NORMALS, "XYZ"), {}))
    assert same_bits(read_normal(path).pixels, NORMALS)


def test_a_background_without_normals_does_no_harm(tmp_path: Path) -> None:
    normals = NORMALS.copy()
    normals[:20] = 0
    normals[21] = np.nan
    assert (read_normal(exr(tmp_path / "n.exr", planes(normals))).pixels[:22] == 0).sum() == 63 * 32
    assert (read_normal(exr(tmp_path / "n.exr", planes(normals * 0))).pixels[20:] == 0).any()


@pytest.mark.parametrize("pixels", [colors(dtype=np.float32), NORMALS / 2 + 0.5])
def test_a_picture_is_no_normals(tmp_path: Path, pixels: np.ndarray) -> None:
    path = exr(tmp_path / "beauty.exr", planes(pixels))
    said = r"no normals in the file: .*\d+% of .*\(layer: 'RGB', if it holds normals"
    with pytest.raises(ReadError, match=said) as caught:
        read_normal(path)
    assert caught.value.code == "no-layer"
    assert same_bits(read_normal(path, layer="RGB").pixels, pixels)


def test_motion(tmp_path: Path) -> None:
    """Four channels X, Y, Z, W are Blender's; of others the convention is said, or they lead to the next frame."""
    four = exr(tmp_path / "a.exr", planes(renders.VECTOR, "XYZW"))
    assert same_bits(read_motion(four).pixels, renders.VECTOR)
    as_colors = exr(tmp_path / "b.exr", planes(renders.VECTOR))
    assert same_bits(read_motion(as_colors, convention="blender").pixels, renders.VECTOR)
    notes: list[str] = []
    np.testing.assert_array_equal(read_motion(as_colors, note=notes.append).pixels[..., 2:], -renders.VECTOR[..., :2])
    assert notes == ["the file's only layer, R, G, is read, as forward"]


def test_a_picture_is_no_motion(tmp_path: Path) -> None:
    path = exr(tmp_path / "beauty.exr", planes(np.abs(colors())))
    said = r"no motion in the file: .*nothing moves left or down \(layer: 'RGB', if it holds motion"
    with pytest.raises(ReadError, match=said):
        read_motion(path)
    assert read_motion(path, layer="RGB").type == "motion"
    nothing_moves = exr(tmp_path / "still.exr", planes(colors() * 0))
    assert not read_motion(nothing_moves).pixels.any()


@pytest.mark.parametrize("names", ["Y", "RGB"])
def test_ids(tmp_path: Path, names: str) -> None:
    channels = planes(np.repeat(renders.INDEX[..., None], len(names), axis=2), names)
    for layer in ("", "material"):
        ids, _ = read_id(exr(tmp_path / "id.exr", channels), layer=layer)
        assert same_bits(ids.pixels[..., 0], renders.INDEX.astype(np.uint32))


def test_a_picture_has_no_ids_and_no_depth(tmp_path: Path) -> None:
    path = exr(tmp_path / "beauty.exr", planes(colors()))
    for read in (read_id, read_depth):
        with pytest.raises(ReadError, match="in its only layer, R, G, B, each pixel has several numbers"):
            read(path)


@pytest.mark.parametrize("read", [read_depth, read_normal, read_motion, read_id])
def test_of_several_layers_none_is_guessed(tmp_path: Path, read: Any) -> None:
    path = exr(tmp_path / "a.exr", planes(colors()) | planes(NORMALS, "XYZ", "other"))
    with pytest.raises(ReadError, match="no layer with a usual name"):
        read(path)


# ---------------------------------------------------------------------- materials


@pytest.mark.parametrize("render", [renders.blender45, renders.blender5])
def test_materials_of_a_cryptomatte(tmp_path: Path, render: Any) -> None:
    path = render(tmp_path / "a.exr", "Near", "Far")
    for layer in ("Far.material", "Far.Material"):
        ids, _ = read_id(path, layer=layer)
        assert ids.origin is not None
        assert ids.origin.layer == "Far.CryptoMaterial00"
    with pytest.raises(ReadError, match="could be read from several places"):
        read_id(path, layer="material")


@pytest.mark.parametrize("name", ["V.IndexMA.X", "V.Material Index.X", "MtlID", "material_id", "VRayMtlID"])
def test_materials_of_an_id_pass(tmp_path: Path, name: str) -> None:
    channels = {name: renders.INDEX} | {
        key: plane for level in renders.crypto_planes("CryptoObject").values() for key, plane in level.items()
    }
    ids, coverage = read_id(exr(tmp_path / "a.exr", channels), layer="material")
    assert same_bits(ids.pixels[..., 0], renders.INDEX.astype(np.uint32))
    assert (coverage.pixels == 1).all()


def test_no_materials(tmp_path: Path) -> None:
    path = renders.renderman(tmp_path / "a.exr")
    with pytest.raises(ReadError, match=r"no layer with a usual name for materials \(cryptomaterial00, materialindex"):
        read_id(path, layer="material")
