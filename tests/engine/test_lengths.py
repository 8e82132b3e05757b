from dataclasses import replace

import numpy as np
import pytest

from flowabs_nodes import load_graph
from flowabs_nodes.engine.lengths import length_factor, scale_lengths
from flowabs_nodes.engine.resize import scale_image
from flowabs_nodes.graph.reference_size import ReferenceSize
from flowabs_nodes.graph.shipped import shipped
from flowabs_nodes.image import Image
from flowabs_nodes.nodes import catalogue
from flowabs_nodes.nodes.declare import Node, Param, Port
from tests.engine.fakes import ADD, IMAGE, SPLIT, picture

LINES = Node(
    type="lines",
    version=1,
    help=".",
    inputs=(IMAGE,),
    outputs=(Port("lines", "matte", "."),),
    params=(
        Param.float("width", 1.0, min=0.05, max=200, unit="px", thin_below=0.9, help="."),
        Param.custom("reference", "max", schema={}, parse=lambda value: None, scales=-1, help="."),
        Param.float("above", 1.0, min=0, above=True, unit="px", help="."),
        Param.bool("flag", True, help="."),
    ),
    run=ADD.run,
)


def test_lengths_grow_and_quantities_per_pixel_shrink():
    values, warnings = scale_lengths(SPLIT, {"length": 2.0, "slope": 4.0}, 2.0)
    assert values == {"length": 4.0, "slope": 2.0}
    assert warnings == ()
    assert scale_lengths(SPLIT, {"length": 2.0, "slope": None}, 2.0)[0] == {"length": 4.0, "slope": None}


def test_a_custom_parameter_scales_only_where_it_is_a_number():
    assert scale_lengths(LINES, {"reference": "p99.5"}, 2.0)[0] == {"reference": "p99.5"}
    assert scale_lengths(LINES, {"reference": 16}, 2.0)[0] == {"reference": 8.0}


def test_a_scaled_value_stays_inside_the_hard_range_and_says_so():
    values, warnings = scale_lengths(SPLIT, {"length": 80.0, "slope": 4.0}, 2.0)
    assert values["length"] == 100
    assert "length 80 x 2 = 160 is not from 0.5 to 100: 100 used" in warnings[0].text
    assert scale_lengths(SPLIT, {"length": 0.6}, 0.5)[0]["length"] == 0.5
    assert scale_lengths(LINES, {"above": 5e-324}, 0.5)[0]["above"] > 0


def test_thin_lines_are_noted_once():
    (note,) = scale_lengths(LINES, {"width": 1.5}, 0.5)[1]
    assert not note.warning, "they are drawn as asked for"
    assert note.once
    assert "width is 0.75 px at this size: below 0.9" in note.text
    assert scale_lengths(LINES, {"width": 1.8}, 0.5)[1] == ()
    assert scale_lengths(LINES, {"width": 0.5}, 1.0)[1] == (), "what the graph says itself needs no warning"
    assert scale_lengths(SPLIT, {"length": 1.5}, 0.5)[1] == (), "a length that draws no lines may be short"


FLOORED = replace(LINES, params=(Param.float("width", 1.0, min=0.05, unit="px", thin_below=1, floor=0.4, help="."),))


@pytest.mark.parametrize(
    ("width", "factor", "used"),
    [
        (1.0, 96 / 540, 0.4),  # a thumbnail
        (1.0, 0.2, 0.4),
        (2.5, 0.01, 0.4),
        (1.0, 0.4, 0.4),
        (0.3, 0.5, 0.3),  # the graph's own value is below the floor: not shortened, nor made longer
        (0.1, 2.0, 0.2),
        (0.1, 1.0, 0.1),
        (1.0, 0.5, 0.5),
    ],
)
def test_scaling_shortens_no_length_below_its_floor(width, factor, used):
    assert scale_lengths(FLOORED, {"width": width}, factor)[0]["width"] == pytest.approx(used)


def test_a_length_held_at_its_floor_is_said_in_one_line():
    (warning,) = scale_lengths(FLOORED, {"width": 1.0}, 0.15)[1]
    assert (warning.warning, warning.text) == (
        True,
        "width 1 x 0.15 = 0.15 px is too short at this size: 0.4 px used",
    )
    assert warning.once
    both = replace(LINES, params=(Param.float("reach", 7.0, min=1, unit="px", floor=2, help="."),))
    (warning,) = scale_lengths(both, {"reach": 7.0}, 0.1)[1]
    assert warning.text == "reach 7 x 0.1 = 0.7 px is too short at this size: 2 px used", "beyond its range as well"
    both = replace(LINES, params=(Param.float("reach", 7.0, min=1, unit="px", floor=0.5, help="."),))
    (warning,) = scale_lengths(both, {"reach": 7.0}, 0.05)[1]
    assert warning.text == "reach 7 x 0.05 = 0.35 is not from 1: 1 used", "the range holds it above its floor"
    assert scale_lengths(FLOORED, {"width": 0.1}, 1.0)[1] == (), "the graph's own value, not scaled"


@pytest.mark.parametrize(("size", "scale"), [((96, 128), 1), ((128, 96), 1), ((64, 64), 1), ((108, 144), 0.5)])
def test_a_small_picture_is_not_a_blank_sheet(size, scale):
    height, width = size
    y, x = np.mgrid[0:height, 0:width]
    disc = np.clip(0.3 * min(size) - np.hypot(x - width / 2, y - height / 2), 0, 1)[..., None]
    plate = Image.from_array(np.broadcast_to(0.1 + 0.5 * disc, (*size, 3)).astype(np.float32))
    lines = load_graph("lines").run(given={"plate": plate}, outputs=["lines"], scale=scale)["lines"].pixels
    assert 0.4 * np.pi * min(lines.shape[:2]) < (lines < 0.5).sum() < 3 * np.pi * min(lines.shape[:2]), (
        "a circle's worth"
    )
    assert lines[0].min() > 1 - 1e-6, "paper, to a rounding of the weights"


def test_the_nodes_that_draw_lines_say_below_which_width_lines_change():
    thin = {
        (node.type, name): param.thin_below
        for node in catalogue().values()
        for name, param in node.all_params.items()
        if param.thin_below is not None
    }
    assert thin == {(type, "sigma_c"): 1.0 for type in ("dog", "fdog", "fdog_iterative")}
    for type, name in thin:
        assert catalogue()[type].all_params[name].floor == 0.4


def test_the_factor_comes_from_the_display_window():
    image = picture()  # 24 high, of which 6 are data
    size = ReferenceSize("height", 48)
    assert length_factor(size, 1.0, image) == 0.5
    assert length_factor(None, 0.25, image) == 0.25
    assert length_factor(size, 0.5, scale_image(image, 0.5)) == 0.25


@pytest.mark.parametrize("name", sorted(shipped()))
def test_a_plate_on_its_side_has_the_lengths_of_the_upright_one(name):
    size = load_graph(name).reference_size
    wide, tall = (Image.from_array(np.zeros((*shape, 3), np.float32)) for shape in ((54, 96), (96, 54)))
    assert length_factor(size, 1.0, wide) == length_factor(size, 1.0, tall) == 0.1


# ---------------------------------------------------------------------- lists: boxes, and sizes of pictures

BOXED = replace(
    LINES,
    params=(
        Param.custom("box", None, schema={}, parse=lambda value: None, scales=1, help="."),
        Param.custom("size", [8, 6], schema={}, parse=lambda value: None, scales=1, of_run=True, help="."),
    ),
)


def test_every_number_of_a_box_scales_and_a_size_by_the_run_alone():
    given = {"box": [1, 2.5, 30, 40], "size": [31, 20]}
    scaled, warnings = scale_lengths(BOXED, given, 2.0, 0.5)
    assert scaled == {"box": [2, 5, 60, 80], "size": [16, 10]}
    assert warnings == ()
    assert scale_lengths(BOXED, given, 2.0, 0.01)[0]["size"] == [1, 1]
    assert scale_lengths(BOXED, given, 1.0, 1.0)[0] == given
    assert scale_lengths(BOXED, {"box": None}, 2.0, 0.5)[0] == {"box": None}
