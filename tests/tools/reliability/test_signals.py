"""Runs that are stopped at random moments, a few of them; ``python -m tools.reliability.signals`` tries hundreds."""

import random
import signal
import sys

import pytest

from tools.reliability.signals import FRAMES, Outcome, stop

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no such signals")


def test_runs_that_are_stopped_at_random_moments_leave_nothing_wrong():
    chance = random.Random(20091)
    outcomes = [stop(chance.choice([signal.SIGINT, signal.SIGTERM]), chance.uniform(0.0, 2.5)) for _ in range(8)]
    assert not [each.fault for each in outcomes if each.fault]
    assert any(each.code in (130, 143) for each in outcomes)


@pytest.mark.slow
def test_runs_that_are_stopped_while_they_compile_leave_nothing_wrong():
    chance = random.Random(20092)
    outcomes = [
        stop(chance.choice([signal.SIGINT, signal.SIGTERM]), chance.uniform(1.0, 8.0), cold=True) for _ in range(4)
    ]
    assert not [each.fault for each in outcomes if each.fault]


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({}, ""),
        ({"code": 0, "made": FRAMES}, ""),
        ({"code": 0, "made": 3}, "SIGINT made it exit 0 with 3 of"),
        ({"code": 124}, "hangs"),
        ({"code": 1}, "exit code 1"),
        ({"code": -2, "made": 0}, ""),
        ({"errors": "Traceback (most recent call last): ..."}, "a traceback"),
        ({"left": (".lines.0001.exr.tmp",)}, "left behind: .lines.0001.exr.tmp"),
    ],
)
def test_what_counts_as_a_fault(changes, fault):
    good = {"number": signal.SIGINT, "moment": 1.0, "code": 130, "seconds": 0.1, "made": 5, "errors": "", "left": ()}
    outcome = Outcome(**(good | changes))
    assert fault in outcome.fault
    assert bool(fault) == bool(outcome.fault)
