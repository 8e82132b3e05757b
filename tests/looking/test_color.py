import numpy as np

from flowabs_nodes.color import srgb
from flowabs_nodes.color.display import find_view, to_display
from flowabs_nodes.image import Image
from flowabs_nodes.looking.color import look_at_color
from tests.color.configs import with_displays, without_displays
from tests.looking.images import image


def test_colour_goes_through_the_default_view():
    plate = Image.from_array(np.random.default_rng(1).random((4, 5, 3)) * 3, "lin_ap1_scene")
    look = look_at_color(plate)
    np.testing.assert_array_equal(look.codes, to_display(plate.pixels, plate.colorspace, find_view()))
    assert look.said == "colour through the view 'ACES 1.0 - SDR Video' of the display 'sRGB - Display'"


def test_alpha_goes_over_black_after_the_view():
    straight = [[[0.4, 0.2, 0.1]]]
    half = look_at_color(image(np.concatenate([np.multiply(straight, 0.5), [[[0.5]]]], axis=2), "color"))
    whole = look_at_color(image(straight, "color"))
    np.testing.assert_allclose(half.codes, whole.codes * 0.5, atol=1e-6)
    assert half.said.endswith(", over black")


def test_the_config_that_is_asked_for(tmp_path):
    ocio = with_displays(tmp_path / "studio.ocio")
    plate = Image.from_array(np.full((1, 1, 3), 0.25, np.float32), "lin_ap1_scene")
    look = look_at_color(plate, ocio)
    np.testing.assert_allclose(look.codes, 0.5, atol=1e-4)
    assert "'film' of the display 'wall'" in look.said


def test_without_a_display_plain_srgb_and_said(tmp_path):
    ocio = without_displays(tmp_path / "studio.ocio")
    look = look_at_color(image([[[0.25, 0.5, np.nan]]], "color"), ocio)
    np.testing.assert_allclose(look.codes, srgb.encoded(np.array([[[0.25, 0.5, 0]]], "f4")), atol=1e-6)
    assert look.said == "colour as plain sRGB: the OCIO config has no display with a view"
