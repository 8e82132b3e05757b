"""Channels are put together to layers, and layers are found by view layer, pass and view."""

from __future__ import annotations

import OpenImageIO as oiio
import pytest

from flowabs_nodes.io.layer_groups import Layer, called, layers_of, of_default_view, within
from tests.io.test_choose import spec


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


def stereo() -> list[oiio.ImageSpec]:
    """Return the header of one part as Blender 4.5 writes two view layers and two views."""
    made = spec(*(f"{name}.{view}.Z" for name in ("Fg.Depth", "Bg.01.Depth", "Fg.Mist") for view in ("left", "right")))
    made.attribute("multiView", "string[2]", ("left", "right"))
    return [made]


def stereo_parts() -> list[oiio.ImageSpec]:
    """Return the headers of the same as Blender 5 writes it: a part for each pass and view."""
    made = []
    for name in ("Fg.Depth", "Bg.01.Depth", "Fg.Mist"):
        for view in ("left", "right"):
            made.append(spec(f"{name}.Z", name=f"{name}-{view}"))
            made[-1].attribute("view", view)
    return made


@pytest.mark.parametrize("specs", [stereo(), stereo_parts()])
def test_names_of_layers_in_stereo(specs: list[oiio.ImageSpec]) -> None:
    layers = layers_of(specs)

    def found(names: list[Layer]) -> list[tuple[str, str]]:
        return [(each.base, each.view) for each in names]

    fg, bg, mist = ([(name, view) for view in ("left", "right")] for name in ("Fg.Depth", "Bg.01.Depth", "Fg.Mist"))
    assert found(layers) == [*fg, *bg, *mist]
    assert found(called(specs, layers, "Fg.Depth")) == fg
    assert found(called(specs, layers, "Bg.01.Depth.right")) == bg[1:]
    assert found(called(specs, layers, "Depth.left")) == [fg[0], bg[0]]
    assert found(called(specs, layers, "depth")) == [*fg, *bg]
    assert found(called(specs, layers, "right")) == []
    assert found(within(specs, layers, "Fg")) == [*fg, *mist]
    assert found(within(specs, layers, "right")) == [fg[1], bg[1], mist[1]]
    assert found(within(specs, layers, "Bg.01.left")) == bg[:1]
    assert found(within(specs, layers, "Bg")) == found(within(specs, layers, "")) == []
    kept, said = of_default_view(specs, layers)
    assert found(kept) == [fg[0], bg[0], mist[0]]
    assert said == "view 'left' is read, one of 2: left, right; `layer` says which"
    assert of_default_view(specs, within(specs, layers, "right"))[1] == ""
