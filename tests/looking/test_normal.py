import numpy as np

from flowabs_nodes.looking.normal import look_at_normal
from tests.looking.images import image


def test_from_minus_1_to_1_as_0_to_1():
    look = look_at_normal(image([[[-1, 0, 1], [0, 2, np.nan]]], "normal"))
    np.testing.assert_array_equal(look.codes, [[[0, 0.5, 1], [0.5, 1, 0]]])
