import numpy as np
import pytest

from flowabs_nodes.looking.stretch import finite_range, grey, stretched

WILD = np.array([2, np.nan, 6, np.inf, -np.inf, 4], np.float32)


def test_the_range_is_of_what_is_finite():
    assert finite_range(WILD) == (2, 6)
    assert finite_range(WILD, (0, 50)) == (2, 4)
    assert finite_range(np.full(3, np.nan, np.float32)) == (0, 0)


def test_stretched_from_0_to_1():
    np.testing.assert_array_equal(stretched(WILD, 2, 6), [0, 0, 1, 1, 0, 0.5])


def test_where_all_is_one_value_it_stays():
    np.testing.assert_array_equal(stretched(np.array([0.25, 3], np.float32), 0.25, 0.25), [0.25, 1])


@pytest.mark.parametrize("most", [np.finfo(np.float32).max])
def test_the_widest_range_does_not_overflow(most):
    values = np.array([-most, 0, most], np.float32)
    np.testing.assert_allclose(stretched(values, *finite_range(values)), [0, 0.5, 1])


def test_grey_has_three_channels():
    np.testing.assert_array_equal(grey(np.array([[0.5]], np.float32)), [[[0.5, 0.5, 0.5]]])
