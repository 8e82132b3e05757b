import numpy as np
import pytest

from flowabs_nodes.looking.motion import look_at_motion
from tests.looking.images import image

RIGHT, UP, LEFT, DOWN = (-4, 0), (0, -4), (4, 0), (0, 4)  # X, Y lead to the place on the previous frame, y up


@pytest.mark.parametrize(
    ("back", "color"),
    [
        (RIGHT, (1, 0.25, 0.25)),
        (UP, (0.5, 0.933, 0.067)),
        (LEFT, (0, 0.75, 0.75)),
        (DOWN, (0.5, 0.067, 0.933)),
    ],
)
def test_a_hue_for_each_direction(back, color):
    look = look_at_motion(image([[[*back, 0, 0], [0, 0, 0, 0]]], "motion"))
    np.testing.assert_allclose(look.codes[0, 0], color, atol=1e-3)
    np.testing.assert_array_equal(look.codes[0, 1], 0.5)
    assert "since the previous frame" in look.said
    assert "full colour at 4 px" in look.said


def test_slower_is_greyer_and_the_fastest_are_cut_off():
    slow = look_at_motion(image([[[-1, 0, 0, 0], *[[-4, 0, 0, 0]] * 300, [-400, 0, 0, 0]]], "motion")).codes[0, :, 0]
    np.testing.assert_allclose(slow[[0, 1, -1]], [0.625, 1, 1], atol=1e-6)


def test_motion_to_the_next_frame_where_there_is_no_other():
    look = look_at_motion(image([[[0, 0, -3, 0]]], "motion"))  # -Z, -W lead to the next place: to the right
    np.testing.assert_allclose(look.codes[0, 0], (1, 0.25, 0.25), atol=1e-6)
    assert "to the next frame" in look.said


def test_nothing_moves():
    look = look_at_motion(image([[[0, 0, 0, 0], [np.nan, 0, 0, 0]]], "motion"))
    np.testing.assert_array_equal(look.codes, 0.5)
    assert look.said == "motion: nothing moves"
