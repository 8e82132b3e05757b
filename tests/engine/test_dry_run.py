"""Dry runs: what is told of each frame, that nothing is made, and how long it takes over many frames."""

import os
import time
from pathlib import Path

import pytest

from flowabs_nodes.engine.dry_run import dry_run
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.errors import CommandError
from tests.engine.sequences import document, plate, plates, run, statuses


def states(shot, out, graph=None, **options):
    planned = dry_run(graph or document(), RunOptions(input=shot, output=out, **options))
    return {each.frame: each.state for each in planned.plans}


def everything(folder):
    return {path: (path.lstat().st_mtime_ns, path.lstat().st_size) for path in [folder, *folder.rglob("*")]}


def test_each_state_is_what_a_run_then_does(shot, out, tmp_path):
    before = everything(tmp_path)
    assert states(shot, out) == {1: "make", 2: "make", 3: "make"}
    assert everything(tmp_path) == before, "not even a folder, nor its time"
    run(shot, out, frames="1-2")
    assert states(shot, out) == {1: "there", 2: "there", 3: "make"}
    assert states(shot, out, existing="overwrite") == {1: "make", 2: "make", 3: "make"}
    assert states(shot, out, existing="error") == {1: "fail", 2: "fail", 3: "make"}
    assert statuses(run(shot, out, existing="error")) == [(1, "failed"), (2, "failed"), (3, "done")]
    assert states(shot, out, scale=0.5) == {1: "other", 2: "other", 3: "other"}
    os.utime(tmp_path / "in/plate.0002.exr", (2**32, 2**32))
    assert states(shot, out) == {1: "there", 2: "newer", 3: "there"}
    plate(Path(out.replace("####", "0001")))
    assert states(shot, out)[1] == "fail", "a file that no run wrote"
    assert statuses(run(shot, out))[0] == (1, "failed")


@pytest.mark.parametrize(
    ("missing", "state"),
    [("error", "fail"), ("skip", "left-out"), ("hold", "make"), ("nearest", "make"), ("black", "make")],
)
def test_a_missing_plate_goes_by_the_policy(tmp_path, out, missing, state):
    shot = plates(tmp_path / "in", 1, 2, 5)
    planned = dry_run(document(), RunOptions(input=shot, output=out, frames="1-5", missing=missing))
    found = {each.frame: each for each in planned.plans}
    assert [found[frame].state for frame in (1, 3, 4)] == ["make", state, state]
    report = run(shot, out, frames="1-5", missing=missing)
    expected = {"fail": "failed", "left-out": "skipped", "make": "done"}
    assert [status for _, status in statuses(report)] == [expected[found[frame].state] for frame in range(1, 6)]
    if missing in ("hold", "nearest"):
        nearest = "5" if missing == "nearest" else "2"
        assert found[4].reads[0].endswith(f"plate.000{nearest}.exr")


def test_windows_of_frames_and_moving_knobs_are_planned_frame_by_frame(shot, out):
    moving = document()
    moving["interface"]["stops"]["default"] = {"curve": {"1": 0.0, "3": 1.0}}
    assert states(shot, out, moving) == {1: "make", 2: "make", 3: "make"}


def test_a_wrong_command_is_refused_as_by_a_run(shot, out, tmp_path):
    for options in (
        {"input": shot, "output": shot},
        {"input": shot, "output": str(tmp_path / "in/plate.0001.exr/x.####.exr")},
    ):
        with pytest.raises(CommandError):
            dry_run(document(), RunOptions(**options))


def test_ten_thousand_frames(tmp_path, out):
    """The goals are 2 s and 20 s; a busy machine gets some more."""
    first = plate(tmp_path / "in" / "plate.0001.exr")
    for frame in range(2, 10_001):
        os.link(first, tmp_path / "in" / f"plate.{frame:04d}.exr")
    shot = str(tmp_path / "in/plate.####.exr")
    start = time.perf_counter()
    assert set(states(shot, out).values()) == {"make"}
    assert time.perf_counter() - start < 4
    run(shot, out, frames=1)
    for frame in range(2, 10_001):
        os.link(out.replace("####", "0001"), out.replace("####", f"{frame:04d}"))
    start = time.perf_counter()
    assert set(states(shot, out).values()) == {"there"}
    assert time.perf_counter() - start < 20
