"""Usual names are compared plainly, and channels are put together to layers."""

from __future__ import annotations

import pytest

from flowabs_nodes.io.layer_groups import Layer, layers_of
from flowabs_nodes.io.pass_names import plain_name
from tests.io.test_choose import spec


@pytest.mark.parametrize(
    ("layer", "plain"),
    [
        ("ViewLayer.Depth", "depth"),
        ("A view.Object Index", "objectindex"),
        ("VRayZDepth", "zdepth"),
        ("Z Depth", "zdepth"),
        ("crypto_object00", "cryptoobject00"),
        ("N", "n"),
        ("VRay", "vray"),
    ],
)
def test_plain_names(layer: str, plain: str) -> None:
    assert plain_name(layer) == plain


def test_layers_are_what_stands_before_the_last_dot() -> None:
    found = layers_of([spec("R", "G", "B", "Z", "a.b.X", "a.b.Y", "a.Z"), spec("x", "y", name="motion")])
    assert [(layer.part, layer.name, tuple(layer.channels.values())) for layer in found] == [
        (0, "a.b", ("a.b.X", "a.b.Y")),
        (0, "a", ("a.Z",)),
        (0, "Z", ("Z",)),
        (0, "", ("R", "G", "B", "Z")),
        (1, "motion", ("x", "y")),
    ]
    assert [layer.name for layer in layers_of([spec("Z"), spec("Z", name="right")], "right")] == ["Z", "right"]


def layer(*last: str) -> Layer:
    return Layer(0, "n", {each: f"n.{each}" for each in last})


@pytest.mark.parametrize(
    ("last", "count", "found"),
    [
        (("Z", "Y", "X"), 3, ("n.X", "n.Y", "n.Z")),
        (("Z", "Y", "X"), 2, ("n.X", "n.Y")),
        (("Z", "Y", "X"), 4, None),
        (("red", "green", "blue"), 3, ("n.red", "n.green", "n.blue")),
        (("u", "v"), 2, ("n.u", "n.v")),
        (("x",), 2, None),
    ],
)
def test_components_of_a_vector(last: tuple[str, ...], count: int, found: tuple[str, ...] | None) -> None:
    assert layer(*last).vector(count) == found


@pytest.mark.parametrize(
    ("last", "found"),
    [
        (("anything",), ("n.anything",)),
        (("Z", "A"), ("n.Z",)),
        (("X", "Y", "Z"), None),
        (("R", "G", "B"), ("n.R", "n.G", "n.B")),
        (("u", "v"), None),
    ],
)
def test_a_single_number(last: tuple[str, ...], found: tuple[str, ...] | None) -> None:
    assert layer(*last).single() == found
