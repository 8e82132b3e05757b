"""The memory of a run over some frames; ``python -m tools.reliability.memory`` watches five hundred."""

import os
import sys

import pytest

from tools.reliability.memory import Outcome, family, pss, watch

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="memory as Linux counts it")


@pytest.mark.slow
def test_a_run_over_some_frames_does_not_grow() -> None:
    outcome = watch("lines", 60, 1, (160, 90))
    assert not outcome.fault
    assert 50 < outcome.peak < 1000


def test_memory_of_this_process() -> None:
    assert os.getpid() in family(os.getpid())
    assert pss(os.getpid()) > 10e6
    assert pss(2**22 + 1) == 0


@pytest.mark.parametrize(("grows", "fault"), [(0.0, ""), (0.01, ""), (0.1, "it grows by 40 MB in 500 frames")])
def test_what_counts_as_a_fault(grows: float, fault: str) -> None:
    outcome = Outcome(tuple((frame, 200 + grows * frame) for frame in range(500)), 0, "", 500)
    assert outcome.slope == pytest.approx(grows, abs=1e-6)
    assert outcome.fault == fault


def test_a_run_that_fails_is_a_fault() -> None:
    assert "exit code 1: no" in Outcome((), 1, "no", 500).fault
