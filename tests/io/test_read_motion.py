"""Motion comes out in Blender's convention, whichever the renderer has."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flowabs_nodes.errors import ReadError
from flowabs_nodes.io.read_motion import read_motion
from tests.io import renders
from tests.io.files import box, exr, parts, planes, same_bits

BLENDER = (renders.blender45, renders.blender5)


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


def test_two_ways_on_two_windows_are_refused(tmp_path: Path) -> None:
    back, fore = planes(renders.VECTOR[..., :2], "uv", "backward"), planes(renders.VECTOR[..., 2:], "uv", "forward")
    path = parts(
        tmp_path / "a.exr",
        ("b", back, {"dataWindow": box(0, 0, 32, 24)}),
        ("f", fore, {"dataWindow": box(1, 0, 32, 24)}),
    )
    with pytest.raises(ReadError, match="layers backward, forward belong together, but have different data windows"):
        read_motion(path)
    assert read_motion(path, convention="forward").data_window == (1, 0, 32, 24)
