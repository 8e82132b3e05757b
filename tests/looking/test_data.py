import numpy as np

from flowabs_nodes.looking.data import look_at_data
from tests.looking.images import image


def test_three_channels_that_belong_together_share_a_range():
    look = look_at_data(image([[[0, 1, 2], [4, 0, 0]]], "data", ("albedo.R", "albedo.G", "albedo.B")))
    np.testing.assert_array_equal(look.codes, [[[0, 0.25, 0.5], [1, 0, 0]]])
    assert look.said == "data albedo.R, albedo.G, albedo.B from 0 to 4 as red, green, blue"


def test_they_are_found_in_any_order_among_others():
    look = look_at_data(image([[[9, 3, 2, 1], [9, 0, 0, 0]]], "data", ("A", "B", "G", "R")))
    np.testing.assert_allclose(look.codes[0, 0], [1 / 3, 2 / 3, 1])
    assert look.said.endswith("; 1 more channel is not shown")


def test_other_channels_have_each_their_own():
    look = look_at_data(image([[[0, 10], [2, 30]]], "data", ("u", "v")))
    np.testing.assert_array_equal(look.codes, [[[0, 0, 0], [1, 1, 0]]])
    assert look.said == "data u from 0 to 2 as red, v from 10 to 30 as green"


def test_one_channel_is_grey():
    look = look_at_data(image([[1, 3, 5]], "data", ("AO",)))
    np.testing.assert_array_equal(look.codes[0, 1], [0.5, 0.5, 0.5])
    assert look.said == "data AO from 1 to 5, black to white"
