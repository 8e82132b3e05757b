import numpy as np
import pytest

from flowabs_nodes.engine.scale import check_scale, length_factor, scale_image, scale_lengths, scale_window
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.image import Image, Window
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


def test_windows_shrink_at_their_edges():
    assert scale_window(Window(0, 0, 1920, 1080), 0.5) == (0, 0, 960, 540)
    assert scale_window(Window(-10, 5, 101, 33), 0.5) == (-5, 3, 51, 16)
    assert scale_window(Window(7, 7, 1, 1), 0.1) == (1, 1, 1, 1)


@pytest.mark.parametrize("scale", [0.5, 0.3, 0.77])
@pytest.mark.parametrize("data", [Window(0, 0, 40, 30), Window(6, 4, 20, 18), Window(-9, -5, 60, 44)])
def test_a_picture_keeps_its_place_brightness_and_metadata(scale, data):
    y, x = np.mgrid[data.y : data.y + data.height, data.x : data.x + data.width] + 0.5
    image = Image.from_array(np.stack([x, y, np.full_like(x, 0.5)], axis=2))
    spec = image.spec
    spec.x, spec.y = data.x, data.y
    spec.full_width, spec.full_height = 40, 30
    spec.attribute("owner", "somebody")
    small = scale_image(Image(image.pixels, spec, "color"), scale)
    assert small.display_window == scale_window(Window(0, 0, 40, 30), scale)
    assert small.data_window == scale_window(data, scale)
    assert small.spec.get("owner") == "somebody"
    window = small.data_window
    rows = (np.arange(window.y, window.y + window.height) + 0.5) * 30 / small.display_window.height
    inside = slice(2, -2)
    np.testing.assert_allclose(small.pixels[:, 3, 1][inside], rows[inside], atol=0.05)
    np.testing.assert_allclose(small.pixels[..., 2], 0.5, atol=1e-5, err_msg="no dark rim")


def test_highlights_make_no_negative_rim_and_opaque_stays_opaque():
    pixels = np.zeros((32, 32, 4), np.float32)
    pixels[8:20, 8:20, :3] = 1000
    pixels[..., 3] = 1
    small = scale_image(Image.from_array(pixels), 0.4)
    assert small.pixels.min() == 0
    assert small.alpha is None


@pytest.mark.parametrize("kind", ["flow", "data"])
def test_directions_and_ids_are_never_mixed(kind):
    rng = np.random.default_rng(1)
    pixels = rng.integers(0, 1000, (20, 30, 2)).astype(np.float32)
    image = Image.from_array(pixels, type=kind)
    small = scale_image(image, 0.5)
    assert small.type == kind
    assert small.channels == image.channels
    assert set(small.pixels[..., 0].ravel()) <= set(pixels[..., 0].ravel())
    np.testing.assert_array_equal(small.pixels, pixels[1::2, 1::2])


def test_full_size_is_the_image_itself():
    image = picture()
    assert scale_image(image, 1.0) is image
