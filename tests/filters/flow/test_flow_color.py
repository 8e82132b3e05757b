import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import flow_color


def color_of(angle, length=1.0):
    tangent = np.array([[[np.cos(angle), np.sin(angle)]]]) * length
    return flow_color(tangent)[0, 0]


def test_known_colours():
    np.testing.assert_allclose(color_of(0), [1, 0.25, 0.25], atol=1e-7)
    np.testing.assert_allclose(color_of(np.pi / 2), [0, 0.75, 0.75], atol=1e-7)
    np.testing.assert_allclose(color_of(np.pi / 3), [0.25, 1, 0.25], atol=1e-6)
    np.testing.assert_allclose(color_of(2 * np.pi / 3), [0.25, 0.25, 1], atol=1e-6)


def test_no_direction_is_grey():
    np.testing.assert_array_equal(flow_color(np.zeros((2, 3, 2))), np.full((2, 3, 3), 0.5))


@given(angle=st.floats(-10, 10), turn=st.floats(-3, 3), length=st.floats(0, 1e30))
def test_orientation_alone_counts_and_equal_turns_are_equally_far(angle, turn, length):
    color = color_of(angle)
    np.testing.assert_allclose(color, color_of(angle + np.pi), atol=1e-5)
    assert np.linalg.norm(color - color_of(angle + turn)) == pytest.approx(np.sqrt(1.5) * abs(np.sin(turn)), abs=1e-5)
    any_length = color_of(angle, length)
    assert (any_length >= 0).all()
    assert (any_length <= 1).all()


def test_the_sign_changes_no_bit():
    flow = np.random.default_rng(0).normal(size=(9, 7, 2))
    np.testing.assert_array_equal(flow_color(flow), flow_color(-flow))


@pytest.mark.parametrize("flow", [np.zeros((3, 3)), np.zeros((3, 3, 3)), np.full((2, 2, 2), np.nan)])
def test_errors_name_the_argument(flow):
    with pytest.raises(ArgumentError, match="flow"):
        flow_color(flow)
