from flowabs_nodes.engine.lengths import length_factor, scale_lengths
from flowabs_nodes.engine.resize import scale_image
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


def test_thin_lines_are_warned_of_once():
    (warning,) = scale_lengths(LINES, {"width": 1.5}, 0.5)[1]
    assert warning.warning
    assert warning.once
    assert "width is 0.75 px at this size: below 0.9" in warning.text
    assert scale_lengths(LINES, {"width": 1.8}, 0.5)[1] == ()
    assert scale_lengths(LINES, {"width": 0.5}, 1.0)[1] == (), "what the graph says itself needs no warning"
    assert scale_lengths(SPLIT, {"length": 1.5}, 0.5)[1] == (), "a length that draws no lines may be short"


def test_the_nodes_that_draw_lines_say_below_which_width_lines_change():
    thin = {
        (node.type, name): param.thin_below
        for node in catalogue().values()
        for name, param in node.all_params.items()
        if param.thin_below is not None
    }
    assert thin == {(type, "sigma_c"): 1.0 for type in ("dog", "fdog", "fdog_iterative")}


def test_the_factor_comes_from_the_display_window():
    image = picture()  # 24 high, of which 6 are data
    assert length_factor(48, 1.0, image) == 0.5
    assert length_factor(None, 0.25, image) == 0.25
    assert length_factor(48, 0.5, scale_image(image, 0.5)) == 0.25
