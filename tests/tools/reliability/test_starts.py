"""One run started several times at once; ``python -m tools.reliability.starts`` starts it twenty times."""

import sys

import pytest

from tools.reliability.runs import shot
from tools.reliability.starts import _faults_of_frames, start_together

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="claims are found dead at once by their locks")


@pytest.mark.slow
def test_every_frame_is_there_once_where_runs_start_at_once_and_some_are_killed() -> None:
    outcome = start_together(4, frames=8, kills=1)
    assert not outcome.faults
    assert set(outcome.codes) == {0}


def test_what_counts_as_a_fault() -> None:
    with shot(2) as here:
        here.made.mkdir()
        for frame in (1, 2):
            (here.made / f"lines.{frame:04}.exr").write_bytes((here.folder / "plate.0001.exr").read_bytes())
        assert not _faults_of_frames(here)
        (here.made / ".lines.0002.exr.claim").touch()
        (here.made / "lines.0001.exr").unlink()
        assert _faults_of_frames(here) == ["1 frames are missing", "left behind: .lines.0002.exr.claim"]
