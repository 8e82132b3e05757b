"""A layer's name finds part and channels, or an error that lists what there is."""

from __future__ import annotations

import OpenImageIO as oiio
import pytest

from flowabs_nodes.errors import ReadError
from flowabs_nodes.io.choose import choose_color, choose_data
from flowabs_nodes.io.layers import Selection


def spec(*channels: str, name: str = "", deep: bool = False) -> oiio.ImageSpec:
    """Return the header of a part with these channels."""
    made = oiio.ImageSpec(4, 4, len(channels), oiio.HALF)
    made.channelnames = channels
    made.deep = deep
    if name:
        made.attribute("oiio:subimagename", name)
    return made


RENDER = spec("R", "G", "B", "A", "Z", "diffuse.R", "diffuse.G", "diffuse.B", "N.X", "N.Y", "N.Z", "lines.Y")


def test_plain_channels_come_first() -> None:
    assert choose_color([RENDER]) == Selection(0, "", ("R", "G", "B", "A"))
    assert choose_color([spec("B", "G", "R")]).channels == ("R", "G", "B")


def test_the_first_part_that_has_them() -> None:
    parts = [
        spec("Z", name="depth"),
        spec("Y", name="grey"),
        spec("R", "G", "B", name="right"),
        spec("R", "G", "B", name="left"),
    ]
    assert choose_color(parts).part == 2
    assert choose_color(parts, part=3).part == 3
    assert choose_color(parts, part="left").part == 3
    assert choose_color(parts, part="1").channels == ("Y",)
    assert choose_color(parts, layer="left").part == 3


@pytest.mark.parametrize("names", [("r", "g", "b", "a"), ("red", "green", "blue", "alpha"), ("Y", "A"), ("Y",)])
def test_other_spellings_and_grey(names: tuple[str, ...]) -> None:
    chosen = choose_color([spec(*names)])
    assert chosen.channels == names
    assert chosen.grey == (names[0] == "Y")
    assert chosen.has_alpha == (len(names) in (2, 4))


def test_a_layer() -> None:
    assert choose_color([RENDER], "diffuse").channels == ("diffuse.R", "diffuse.G", "diffuse.B")
    assert choose_color([RENDER], "lines").channels == ("lines.Y",)


def test_blenders_combined_is_read_and_noted() -> None:
    parts = [
        spec(*(f"ViewLayer.Combined.{c}" for c in "RGBA"), name="ViewLayer.Combined"),
        spec(*(f"ViewLayer.Crypto00.{c}" for c in "rgba"), name="ViewLayer.Crypto00"),
    ]
    chosen = choose_color(parts)
    assert (chosen.part, chosen.layer) == (0, "ViewLayer.Combined")
    assert "ViewLayer.Combined" in chosen.note
    assert choose_color([spec("beauty.R", "beauty.G", "beauty.B", "Z")]).layer == "beauty"


@pytest.mark.parametrize(
    ("names", "listed"),
    [
        (("A",), "A"),
        (("A", "Z"), "A, Z"),
        (("forward.u", "forward.v"), "forward.uv"),
        (("G",), "G"),
        (("R", "G"), "R, G"),
        (("X", "Y", "Z"), "X, Y, Z"),
        (("N.X", "Z", "N.Y", "crypto00.red"), "N.XY, Z, crypto00.red"),
        (("Y", "RY", "BY"), "Y, RY, BY"),
    ],
)
def test_no_colour_is_refused_with_what_there_is(names: tuple[str, ...], listed: str) -> None:
    with pytest.raises(ReadError, match=f"it has {listed}$") as caught:
        choose_color([spec(*names)])
    assert caught.value.code == "no-color"


def test_two_layers_are_a_question() -> None:
    with pytest.raises(ReadError, match="layer: 'a' or 'b'"):
        choose_color([spec(*(f"{layer}.{c}" for layer in "ab" for c in "RGB"))])


def test_a_wrong_name_gets_the_nearest() -> None:
    with pytest.raises(ReadError, match=r"not in the file.*did you mean 'diffuse'") as caught:
        choose_color([RENDER], "difuse")
    assert (caught.value.code, caught.value.parameter) == ("unknown-layer", "layer")
    with pytest.raises(ReadError, match="no red, green and blue"):
        choose_color([RENDER], "N")
    with pytest.raises(ReadError, match="did you mean 'depth'") as caught:
        choose_color([spec("Z", name="depth"), spec("R", "G", "B", name="rgba")], part="deptth")
    assert (caught.value.code, caught.value.parameter) == ("no-part", "part")
    with pytest.raises(ReadError, match="it has 1"):
        choose_color([RENDER], part=1)


def test_data() -> None:
    assert choose_data([RENDER], "N").channels == ("N.X", "N.Y", "N.Z")
    assert choose_data([RENDER], "Z").channels == ("Z",)
    assert choose_data([RENDER], "N.Y").channels == ("N.Y",)
    assert len(choose_data([RENDER]).channels) == 12
    parts = [spec("R", "G", "B", name="rgba"), spec("Z", name="depth_left")]
    assert choose_data(parts, "depth_left") == Selection(1, "depth_left", ("Z",))
    assert choose_data(parts, "Z").part == 1
    with pytest.raises(ReadError, match="did you mean 'depth_left'"):
        choose_data(parts, "depth_lef")


def test_deep_parts_are_not_read() -> None:
    assert choose_color([spec("R", "G", "B", deep=True), spec("R", "G", "B")]).part == 1
    for call in (choose_color, choose_data):
        with pytest.raises(ReadError, match="deep") as caught:
            call([spec("R", "G", "B", deep=True)])
        assert caught.value.code == "deep"
    with pytest.raises(ReadError, match="deep"):
        choose_color([spec("R", "G", "B", deep=True), spec("R", "G", "B")], part=0)


def test_hostile_names_do_not_reach_the_terminal() -> None:
    with pytest.raises(ReadError) as caught:
        choose_color([spec("\x1b[2J", *(f"c{i}" for i in range(500)), "x" * 5000)])
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 500


@pytest.mark.parametrize(
    ("names", "picture"),
    [
        (("N", "albedo", "rgba"), "rgba"),
        (("N", "beauty", "Z"), "beauty"),
        (("position", "hero"), "hero"),
        (("albedo", "ViewLayer.Combined", "ViewLayer.Normal"), "ViewLayer.Combined"),
        (("diffuse", "RGBA.left", "RGBA.right"), "RGBA.left"),
        (("left", "right"), "left"),
        (("N", "P"), "N"),
    ],
)
def test_the_part_named_as_a_picture_is_read_and_noted(names: tuple[str, ...], picture: str) -> None:
    chosen = choose_color([spec("R", "G", "B", name=name) for name in names])
    assert names[chosen.part] == picture
    assert chosen.note.startswith(f"part {picture!r} is read, one of {len(names)} with colour")
    assert choose_color([spec("R", "G", "B", name=name) for name in names], part=names[0]).part == 0


def layers(*names: str) -> list[str]:
    return [f"{name}.{channel}" for name in names for channel in "RGB"]


def test_the_only_view_layer_goes_before_the_compositors_picture() -> None:
    both = [spec(*layers("ViewLayer.Combined", "Composite.Combined", "ViewLayer.Normal"))]
    chosen = choose_color(both)
    assert chosen.layer == "ViewLayer.Combined"
    assert "one of 3" in chosen.note
    assert choose_color(both, "Composite").layer == "Composite.Combined"
    assert choose_color([spec(*layers("Composite.Combined"))]).layer == "Composite.Combined"


def test_of_several_view_layers_and_a_composite_none_is_chosen() -> None:
    made = [spec(*layers("A.Combined", "Composite.Combined", "B.b.Combined", "A.Diffuse Color"))]
    with pytest.raises(ReadError, match=r"layer: 'A\.Combined' or 'Composite.*' or 'B\.b\.Combined'; ") as caught:
        choose_color(made)
    assert caught.value.code == "ambiguous-layer"
    assert choose_color(made, "A").layer == "A.Combined"
    assert choose_color(made, "B.b").layer == "B.b.Combined"


def test_a_layer_named_as_a_picture_is_read() -> None:
    assert choose_color([spec(*layers("N", "beauty", "albedo"))]).layer == "beauty"
    normals_first = [spec("R", "G", "B", name="N"), spec(*layers("beauty"), name="beauty")]
    assert choose_color(normals_first).layer == "beauty"


def test_of_stereo_layers_the_first_view_is_read() -> None:
    both = spec(*layers("ViewLayer.Combined.right", "ViewLayer.Combined.left"))
    assert choose_color([both]).layer == "ViewLayer.Combined.left"
    both.attribute("multiView", "string[2]", ("right", "left"))
    assert choose_color([both]).layer == "ViewLayer.Combined.right"


def test_two_view_layers_are_a_question() -> None:
    with pytest.raises(ReadError, match=r"'A.Combined' or 'B.Combined'"):
        choose_color([spec(*layers("A.Combined", "B.Combined"))])
