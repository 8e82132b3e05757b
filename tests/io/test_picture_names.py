"""The picture is told from its passes by its name."""

from __future__ import annotations

import pytest

from flowabs_nodes.io.picture_names import is_other, is_picture, rank


@pytest.mark.parametrize(
    "name",
    ["rgba", "RGBA_left", "beauty", "Beauty.v02", "ViewLayer.Combined", "Combined.left", "C", "Ci", "main", "rgb"],
)
def test_pictures(name: str) -> None:
    assert is_picture(name)
    assert not is_other(name)


@pytest.mark.parametrize(
    "name", ["N", "normals", "ViewLayer.Normal", "P", "albedo", "uv", "depth_left", "CryptoObject00", "motionVector"]
)
def test_passes(name: str) -> None:
    assert is_other(name)
    assert not is_picture(name)


@pytest.mark.parametrize("name", ["", "left", "part0", "ViewLayer", "fx", "hero"])
def test_names_that_say_nothing_are_between(name: str) -> None:
    assert not is_picture(name)
    assert not is_other(name)
    assert rank("rgba") < rank("beauty") < rank("Combined") < rank(name) < rank("N")


def test_the_render_goes_before_what_the_compositor_made() -> None:
    assert rank("ViewLayer.Combined") < rank("Composite.Combined")
