"""The time of each piece of work, and of work inside of work."""

import time

import pytest

from flowabs_nodes.engine.stopwatch import Stopwatch


class Watcher:
    def __init__(self):
        self.told = []

    def begins(self, work):
        self.told.append(("begins", work))

    def ends(self, work, seconds):
        self.told.append(("ends", work, seconds))


def test_work_inside_counts_for_itself_alone():
    watch = Stopwatch()
    with watch.of("out", 3):
        time.sleep(0.02)
        with watch.of("(finishing comp)", 3):
            time.sleep(0.1)
    inner, outer = watch.timings
    assert (inner.work, inner.frame, outer.work, outer.frame) == ("(finishing comp)", 3, "out", 3)
    assert inner.seconds >= 0.1
    assert 0.02 <= outer.seconds < 0.1


def test_work_that_fails_has_its_time_too():
    watch = Stopwatch()
    with pytest.raises(ValueError, match="no"), watch.of("flow", 1):
        raise ValueError("no")
    assert [timing.work for timing in watch.timings] == ["flow"]


def test_a_watcher_is_told_at_once_and_gets_the_whole_time():
    watcher = Watcher()
    watch = Stopwatch(watcher)
    with watch.of("out", 1):
        assert watcher.told == [("begins", "out")]
        with watch.of("inside", 1):
            time.sleep(0.05)
    assert [each[:2] for each in watcher.told] == [
        ("begins", "out"),
        ("begins", "inside"),
        ("ends", "inside"),
        ("ends", "out"),
    ]
    assert watcher.told[-1][2] >= 0.05
