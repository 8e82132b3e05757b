"""Ids come out exact, from Cryptomattes and from passes of whole numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flowabs_nodes.errors import ReadError
from flowabs_nodes.io.read_id import read_id
from tests.io import renders
from tests.io.files import colors, exr, planes, same_bits

BLENDER = (renders.blender45, renders.blender5)


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


@pytest.mark.parametrize("wrong", [0.5, np.nan, np.inf, 2.0**33])
def test_numbers_that_are_no_ids(tmp_path: Path, wrong: float) -> None:
    path = exr(tmp_path / "a.exr", {"id": np.array([[1, wrong]], np.float32)})
    with pytest.raises(ReadError, match=r"1 of the numbers .*read_aov"):
        read_id(path)


def test_a_cryptomatte_in_half_has_lost_its_ids(tmp_path: Path) -> None:
    channels = {f"CryptoObject00.{each}": np.ones((2, 3), np.float16) for each in "rgba"}
    with pytest.raises(ReadError, match="32-bit floats"):
        read_id(exr(tmp_path / "a.exr", channels))
