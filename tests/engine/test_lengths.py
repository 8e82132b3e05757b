import pytest

from flowabs_nodes.engine.lengths import check_scale, length_factor, scale_lengths
from flowabs_nodes.engine.resize import scale_image
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.nodes.declare import Node, Param, Port
from tests.engine.fakes import ADD, IMAGE, SPLIT, picture

LINES = Node(
    type="lines",
    version=1,
    help=".",
    inputs=(IMAGE,),
    outputs=(Port("lines", "matte", "."),),
    params=(
        Param.float("sigma_c", 1.0, min=0.05, max=200, unit="px", help="."),
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


def test_thin_lines_are_warned_of_once():
    (warning,) = scale_lengths(LINES, {"sigma_c": 1.5}, 0.5)[1]
    assert warning.warning
    assert warning.once
    assert "sigma_c is 0.75 px" in warning.text
    assert scale_lengths(LINES, {"sigma_c": 2.0}, 0.5)[1] == ()
    assert scale_lengths(LINES, {"sigma_c": 0.5}, 1.0)[1] == (), "what the graph says itself needs no warning"


def test_the_factor_comes_from_the_display_window():
    image = picture()  # 24 high, of which 6 are data
    assert length_factor(48, 1.0, image) == 0.5
    assert length_factor(None, 0.25, image) == 0.25
    assert length_factor(48, 0.5, scale_image(image, 0.5)) == 0.25


@pytest.mark.parametrize("scale", [0, -1, 1.5, float("nan"), True, "half", None])
def test_scale_must_be_a_share(scale):
    with pytest.raises(ArgumentError, match="above 0 up to 1"):
        check_scale(scale)
