import numpy as np

from flowabs_nodes.looking.grey import look_at_grey
from tests.looking.images import image


def test_a_matte_is_shown_as_it_is_and_cut_off():
    look = look_at_grey(image([[-0.5, 0, 0.25, 2]], "matte"))
    np.testing.assert_array_equal(look.codes[0, :, 0], [0, 0, 0.25, 1])
    assert look.said == "matte as it is: 0 black, 1 white"


def test_a_mono_of_0_to_1_is_shown_as_it_is():
    look = look_at_grey(image([[0.25, 0.5]], "mono"))
    np.testing.assert_array_equal(look.codes[0, :, 0], [0.25, 0.5])


def test_a_response_is_stretched_and_a_few_strong_pixels_do_not_count():
    values = np.linspace(-2, 2, 1000).reshape(20, 50)
    values[0, 0] = -500
    look = look_at_grey(image(values, "mono"))
    np.testing.assert_allclose(np.median(look.codes), 0.5, atol=0.01)
    assert look.codes[0, 0, 0] == 0
    assert look.said.startswith("mono from -1.98 (black) to 1.98 (white), of values from -500 to 2")


def test_one_line_on_an_even_ground_is_still_seen():
    values = np.zeros((40, 40))
    values[3, 3] = -5
    look = look_at_grey(image(values, "mono"))
    assert look.codes[3, 3, 0] == 0
    assert look.codes[0, 0, 0] == 1
