"""Frames a second and the time left."""

import pytest

from flowabs_nodes.cli.pace import Pace


def test_nothing_is_known_before_the_first_frame():
    pace = Pace(0)
    assert (pace.frames_per_second, pace.left(3, 5)) == (None, None)


def test_the_first_frame_counts_until_there_is_another():
    pace = Pace(0)
    pace.made(60)
    assert pace.left(2, 60) == pytest.approx(120)
    pace.made(62)
    assert pace.frames_per_second == pytest.approx(0.5)
    assert pace.left(10, 62) == pytest.approx(20)


def test_time_that_the_frame_at_work_has_taken_counts_but_not_more_than_a_frame():
    pace = Pace(0)
    pace.made(2)
    assert [pace.left(3, now) for now in (2, 3, 4, 9)] == pytest.approx([6, 5, 4, 4])


def test_frames_that_are_there_already_are_no_measure():
    pace = Pace(0)
    pace.not_made(3)
    pace.made(5)
    assert pace.frames_per_second == pytest.approx(0.5)


def test_the_last_frames_count():
    pace = Pace(0)
    for frame in range(30):
        pace.made(frame * 10)
    for frame in range(1, 40):
        pace.made(290 + frame)
    assert pace.frames_per_second == pytest.approx(1)
