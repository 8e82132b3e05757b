import numpy as np

from flowabs_nodes.looking.ids import look_at_ids
from tests.looking.images import image


def test_an_id_has_one_colour_everywhere_and_the_background_is_black():
    look = look_at_ids(image([[0, 7, 4294967295], [7, 8, 0]], "id"))
    other = look_at_ids(image([[8, 8, 7]], "id"))
    assert not look.codes[0, 0].any()
    np.testing.assert_array_equal(look.codes[0, 1], look.codes[1, 0])
    np.testing.assert_array_equal(look.codes[1, 1], other.codes[0, 0])
    np.testing.assert_array_equal(look.codes[0, 1], other.codes[0, 2])
    assert look.said == "3 ids, each in a colour of its own; 0, the background, is black"


def test_neighbouring_ids_look_different():
    colors = look_at_ids(image([np.arange(1, 65)], "id")).codes[0]
    apart = np.linalg.norm(colors[1:] - colors[:-1], axis=1)
    assert np.mean(apart > 0.15) > 0.9
    assert (colors.max(axis=1) > 0.4).all()  # nor are they taken for the background
