"""Views of a stereo part: which channels are whose, and what they are called when another view is the default."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from flowabs_nodes.io.read import read_image
from flowabs_nodes.io.views import renamed, view_of, views_there
from tests.io.files import colors, exr, like, native, planes, written

VIEWS = ("right", "left")


@pytest.mark.parametrize(
    ("channel", "view"),
    [
        ("R", "right"),
        ("Z", "right"),
        ("left.R", "left"),
        ("diffuse.left.R", "left"),
        ("diffuse.R", ""),
        ("right.R", "right"),
    ],
)
def test_the_view_of_a_channel(channel: str, view: str) -> None:
    assert view_of(channel, VIEWS) == view


@pytest.mark.parametrize(
    ("channel", "name"),
    [
        ("R", "right.R"),
        ("left.R", "R"),
        ("left.Z", "Z"),
        ("d.left.R", "d.R"),
        ("d.R", "d.R"),
        ("d.right.R", "d.right.R"),
    ],
)
def test_another_default(channel: str, name: str) -> None:
    assert renamed(channel, VIEWS, "left") == name
    assert renamed(channel, VIEWS, "right") == channel


def test_views_that_are_there() -> None:
    assert views_there(["R", "left.R"], VIEWS, "right") == VIEWS
    assert views_there(["R", "diffuse.R"], VIEWS, "right") == ("right",)
    assert views_there(["R", "right.R"], VIEWS, "left") == ("left", "right")


def stereo(tmp_path: Path, views: tuple[str, ...] = VIEWS) -> tuple[Path, dict[str, np.ndarray]]:
    """Write one part with a picture and a depth for each view, the first as the default."""
    channels: dict[str, np.ndarray] = {}
    for seed, view in enumerate(views):
        prefix = "" if seed == 0 else f"{view}."
        channels |= {prefix + name: plane for name, plane in planes(colors(seed=seed)).items()}
        channels[prefix + "Z"] = np.full((24, 32), seed, np.float32)
    return exr(tmp_path / "stereo.exr", channels, multiView=list(views)), channels


def head(path: Path) -> tuple[object, object]:
    header = OpenEXR.File(str(path), header_only=True).header()
    return header.get("multiView"), header.get("view")


def test_a_view_that_is_left_out_is_not_named(tmp_path: Path) -> None:
    plate, _ = stereo(tmp_path)
    assert head(written(read_image(plate), tmp_path / "right.exr")[0]) == (None, "right")
    assert head(written(read_image(plate, layer="left"), tmp_path / "left.exr")[0]) == (None, "left")


def test_kept_views_have_their_own_names(tmp_path: Path) -> None:
    plate, channels = stereo(tmp_path)
    image = read_image(plate)
    out, _ = written(like(image, image.pixels + 1), tmp_path / "right.exr", keep_layers="*")
    assert head(out) == (["right", "left"], None)
    np.testing.assert_array_equal(native(out)["left.R"], channels["left.R"])
    np.testing.assert_array_equal(native(out)["Z"], channels["Z"])
    image = read_image(plate, layer="left")
    out, _ = written(like(image, image.pixels + 1), tmp_path / "left.exr", keep_layers="*")
    assert head(out) == (["left", "right"], None)
    found = native(out)
    np.testing.assert_array_equal(found["right.R"], channels["R"])
    np.testing.assert_array_equal(found["right.Z"], channels["Z"])
    np.testing.assert_array_equal(found["Z"], channels["left.Z"])
    np.testing.assert_allclose(found["R"], channels["left.R"] + 1, rtol=1e-3)
    assert "left.R" not in found


def test_three_views(tmp_path: Path) -> None:
    plate, channels = stereo(tmp_path, ("mid", "left", "right"))
    out, _ = written(read_image(plate, layer="right"), tmp_path / "out.exr", keep_layers="left*,mid")
    assert head(out) == (["right", "mid", "left"], None)
    np.testing.assert_array_equal(native(out)["mid.G"], channels["G"])
    out, _ = written(read_image(plate), tmp_path / "out.exr", keep_layers="left")
    assert head(out) == (["mid", "left"], None)


def test_which_view_is_read_is_told(tmp_path: Path) -> None:
    notes: list[str] = []
    read_image(stereo(tmp_path)[0], note=notes.append)
    assert notes[0] == "view 'right' is read, one of 2: right, left; `layer` says which"


def test_views_that_the_plate_has_not_either_stay_as_they_are(tmp_path: Path) -> None:
    plate = exr(tmp_path / "a.exr", planes(colors()), multiView=["right", "left"])
    assert head(written(read_image(plate), tmp_path / "out.exr")[0]) == (["right", "left"], None)
