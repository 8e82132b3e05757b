"""Of a Cryptomatte the id that covers most of a pixel is taken, or the background."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes.io.cryptomatte import base_name, declared
from flowabs_nodes.io.read_id import read_id
from tests.io.files import exr, parts
from tests.io.test_choose import spec


def level(*pixels: tuple[int, float, int, float]) -> dict[str, np.ndarray]:
    """Return R, G, B, A of one row of pixels: an id, its coverage, the next id, its coverage."""
    ids, first, others, second = zip(*pixels, strict=True)
    return {
        "R": np.array([ids], np.uint32).view(np.float32),
        "G": np.array([first], np.float32),
        "B": np.array([others], np.uint32).view(np.float32),
        "A": np.array([second], np.float32),
    }


def layer(name: str, channels: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    return {f"{name}.{each}": plane for each, plane in channels.items()}


LARGE = 3512605470

ROW = ((LARGE, 1.0, 0, 0.0), (LARGE, 0.5, 7, 0.5), (LARGE, 0.5, 7, 0.25), (LARGE, 0.25, 7, 0.25), (0, 0.0, 0, 0.0))


def test_the_background_wins_where_it_has_more_than_the_first_id(tmp_path: Path) -> None:
    ids, coverage = read_id(exr(tmp_path / "a.exr", layer("cryptomatte00", level(*ROW))))
    np.testing.assert_array_equal(ids.pixels[0, :, 0], [LARGE, LARGE, LARGE, 0, 0])
    np.testing.assert_array_equal(coverage.pixels[0, :, 0], [1, 0.5, 0.5, 0.5, 1])


@pytest.mark.parametrize("apart", [False, True])
def test_ids_of_further_levels_leave_less_to_the_background(tmp_path: Path, apart: bool) -> None:
    first, second = layer("crypto_object00", level(*ROW)), layer("crypto_object01", level(*((9, 0.2, 8, 0.2),) * 5))
    if apart:
        path = parts(tmp_path / "a.exr", ("one", first, {}), ("two", second, {}))
    else:
        path = exr(tmp_path / "a.exr", first | second)
    ids, _ = read_id(path)
    np.testing.assert_array_equal(ids.pixels[0, :, 0], [LARGE, LARGE, LARGE, LARGE, 0])


def test_attributes_are_collected_over_all_parts() -> None:
    first, second = spec("R"), spec("crypto_a00.R")
    first.attribute("cryptomatte/1234567/name", "crypto_a")
    second.attribute("cryptomatte/1234567/manifest", "{}")
    second.attribute("cryptomatte/89/name", "b.c")
    found = declared([first, second])
    assert set(found) == {"crypto_a", "b.c"}
    assert found["crypto_a"] == {"cryptomatte/1234567/name": "crypto_a", "cryptomatte/1234567/manifest": "{}"}
    assert declared([oiio.ImageSpec(1, 1, 1, "float")]) == {}


@pytest.mark.parametrize(
    ("name", "base"),
    [("a.CryptoObject00", "a.CryptoObject"), ("a.CryptoObject12", "a.CryptoObject"), ("crypto", "crypto")],
)
def test_names_of_levels(name: str, base: str) -> None:
    assert base_name(name) == base
