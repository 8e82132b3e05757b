"""Two drawings of the same edges joined to one."""

import numpy as np
import pytest

from flowabs_nodes import filters
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import halo
from tests.filters.flows import THIN
from tests.naive import join_lines as naive


def drawings(shape=(41, 53), seed=0):
    """Return two sparse drawings, soft and hard, the second one with more ink."""
    random = np.random.default_rng(seed)
    over = np.where(random.random(shape) < 0.03, random.random(shape), 1)
    under = np.where(random.random(shape) < 0.3, random.random(shape), 1)
    over[random.random(shape) < 0.02] = 0
    return over.astype(np.float32), under.astype(np.float32)


def line_at(x, shape=(20, 60)):
    """Return a drawing of one vertical line of a pixel."""
    lines = np.ones(shape, np.float32)
    lines[:, x] = 0
    return lines


@pytest.mark.parametrize("gap", [0.0, 0.4, 1.0, 2.5, 6.0, 23.0])
def test_equals_the_formula_in_float64(gap):
    over, under = drawings()
    found = filters.join_lines(over, under, gap)
    np.testing.assert_allclose(found, naive.join_lines(over, under, gap), rtol=0, atol=1e-6)
    assert gap == 0 or np.abs(found - np.minimum(over, under)).max() > 0.2


@pytest.mark.parametrize("shape", THIN)
def test_thin_pictures(shape):
    over, under = drawings(shape)
    found = filters.join_lines(over, under, 2.5)
    np.testing.assert_allclose(found, naive.join_lines(over, under, 2.5), rtol=0, atol=1e-6)


def test_without_a_gap_it_is_the_darker_one():
    over, under = drawings()
    np.testing.assert_array_equal(filters.join_lines(over, under, 0), np.minimum(over, under))


def test_no_ink_of_the_upper_drawing_is_lost_and_none_is_made():
    over, under = drawings()
    joined = filters.join_lines(over, under)
    assert (joined <= over).all()
    assert (joined >= np.minimum(over, under)).all()


@pytest.mark.parametrize(("apart", "doubled"), [(1, False), (2, False), (4, True)])
def test_a_line_beside_another_one_goes_where_it_is_near(apart, doubled):
    over, under = line_at(30), line_at(30 + apart)
    joined = filters.join_lines(over, under, 2.5)
    np.testing.assert_array_equal(joined, np.minimum(over, under) if doubled else over)


def test_a_line_as_far_as_the_gap_is_half_gone():
    joined = filters.join_lines(line_at(30), line_at(33), 3.0)
    np.testing.assert_allclose(joined[:, 33], 0.5)


def test_thin_ink_clears_as_much_as_black_and_a_trace_nothing():
    under = line_at(32)
    for ink, left in ((0.85, 0), (0.5, 0.5), (0.15, 1)):
        over = 1 - (1 - line_at(30)) * np.float32(ink)
        assert 1 - filters.join_lines(over, under, 4.0)[5, 32] == pytest.approx(left, abs=1e-5)


def test_a_line_that_leads_up_to_another_one_stops_before_it():
    over, under = line_at(30, (60, 60)), line_at(30, (60, 60)).T
    ink = 1 - filters.join_lines(over, under, 2.5)[30]
    np.testing.assert_array_equal(ink[:28], 1)
    np.testing.assert_array_equal(ink[28:33], [0, 0, 1, 0, 0])


def test_a_picture_turned_over_has_its_drawing_turned_over():
    over, under = drawings()
    joined = filters.join_lines(over, under)
    np.testing.assert_array_equal(filters.join_lines(over[:, ::-1], under[:, ::-1])[:, ::-1], joined)
    np.testing.assert_array_equal(filters.join_lines(over.T, under.T).T, joined)


@pytest.mark.parametrize("gap", [0.4, 2.5, 7.0])
def test_a_window_with_its_halo_has_the_same_bits(gap):
    over, under = drawings((80, 90))
    far = halo.join_lines(gap)
    whole = filters.join_lines(over, under, gap)[20:41, 30:52]
    window = slice(20 - far, 41 + far), slice(30 - far, 52 + far)
    part = filters.join_lines(over[window], under[window], gap)
    np.testing.assert_array_equal(part[far : far + 21, far : far + 22], whole)


def test_the_same_bits_on_any_number_of_threads(each_thread_count):
    over, under = drawings((150, 37))
    one, *others = each_thread_count(lambda: filters.join_lines(over, under))
    for other in others:
        np.testing.assert_array_equal(one, other)


def test_errors_name_the_argument():
    over, under = drawings()
    for message, arguments in {
        r"lines: expected shape \(H, W\)": (over[..., None], under),
        r"under: expected the size of the picture, 53x41, found 53x40": (over, under[1:]),
        r"under: expected finite pixels": (over, np.where(under == 1, np.inf, under)),
        r"gap: expected a number at least 0 and at most 500, found -1": (over, under, -1),
    }.items():
        with pytest.raises(ArgumentError, match=message):
            filters.join_lines(*arguments)
