import numpy as np
import pytest

from flowabs_nodes.color import srgb
from flowabs_nodes.image import Image
from flowabs_nodes.looking.color import look_at_color
from flowabs_nodes.looking.depth import look_at_depth
from flowabs_nodes.looking.picture import picture_of
from flowabs_nodes.port_types import TYPES
from tests.looking.images import image


def of_type(name):
    declared = TYPES[name]
    shape = (6, 7, len(declared.typical_channels))
    low, high = declared.usual
    array = np.random.default_rng(3).uniform(low, high - 1 if declared.dtype.kind == "u" else high, shape)
    return Image.from_array(array.astype(declared.dtype), type=name, channels=declared.typical_channels)


@pytest.mark.parametrize("name", TYPES)
def test_an_image_of_any_type_can_be_looked_at(name):
    source = of_type(name)
    picture, said = picture_of(source)
    assert picture.type == "color"
    assert picture.channels == ("R", "G", "B")
    assert picture.data_window == source.data_window
    assert np.ptp(picture.pixels) > 0.1
    assert picture.pixels.min() >= 0
    assert picture.pixels.max() <= 1
    assert said


def test_encoded_as_srgb_it_is_what_the_screen_is_sent():
    for source, look in ((of_type("color"), look_at_color), (of_type("depth"), look_at_depth)):
        picture, said = picture_of(source)
        np.testing.assert_allclose(srgb.encoded(picture.pixels), look(source).codes.clip(0, 1), atol=1e-5)
        assert said == look(source).said


def test_windows_and_pixel_aspect_stay_and_what_the_plate_says_of_colours_goes():
    source = of_type("color")
    spec = source.spec
    spec.x, spec.y = 3, -2
    spec.full_x, spec.full_y, spec.full_width, spec.full_height = 0, 0, 32, 24
    spec.attribute("PixelAspectRatio", 2.0)
    spec.attribute("oiio:ColorSpace", "ACEScg")
    source = Image(source.pixels, spec, "color", colorspace="lin_ap1_scene")
    picture, _ = picture_of(source)
    assert (picture.data_window, picture.display_window) == (source.data_window, source.display_window)
    assert picture.spec.get_float_attribute("PixelAspectRatio") == 2
    assert picture.spec.getattribute("oiio:ColorSpace") is None


def test_nan_and_inf_are_counted():
    assert picture_of(image([[1, np.nan, np.inf]], "data", ("Z",)))[1].endswith("; 2 NaN or Inf")
