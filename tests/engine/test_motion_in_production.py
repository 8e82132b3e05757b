"""A steady shot however it is made: a frame alone, in a run, in parallel; and what changes with which file."""

import json
from pathlib import Path

import numpy as np
import pytest

import flowabs_nodes as fa
from flowabs_nodes import engine
from flowabs_nodes.engine.dry_run import dry_run
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.submit.openjd_template import job_template
from tests.engine.moving import frame_file, moving_shot, steady
from tests.engine.sequences import codes, pixels, statuses
from tests.engine.windows import load

FRAMES = range(1000, 1010)
BOTH = pytest.mark.parametrize("flow", [False, True], ids=["motion pass", "optical flow"])


@pytest.fixture(scope="module")
def shot(tmp_path_factory):
    return moving_shot(tmp_path_factory.mktemp("shot"), FRAMES)


@pytest.fixture
def own_shot(tmp_path):
    """A shot that a test may change."""
    return moving_shot(tmp_path / "in", FRAMES)


def run(graph, out, frames=None, **options):
    return engine.run(graph, output=str(out / "out.####.exr"), frames=frames, **options)


def files(out):
    """Return the bytes of every file of a run."""
    return {path.name: path.read_bytes() for path in sorted(out.glob("*.exr"))}


def done(report):
    return [frame for frame, status in statuses(report) if status == "done"]


@BOTH
def test_a_frame_alone_is_that_of_a_run_and_of_a_parallel_run(shot, tmp_path, flow):
    graph = load(steady(shot, flow=flow))
    assert run(graph, tmp_path).exit_code == 0
    expected = files(tmp_path)
    assert len(expected) == len(FRAMES)
    assert run(graph, tmp_path, jobs=2, existing="overwrite").exit_code == 0
    assert files(tmp_path) == expected
    for frame in (1000, 1004, 1009):  # neighbours are read though nobody asked for them
        (tmp_path / f"out.{frame}.exr").unlink()
        assert done(run(graph, tmp_path, frame)) == [frame]
    assert files(tmp_path) == expected
    with fa.Session(graph) as session:
        for frame in (1005, 1003):
            found = session.run("soft", frame=frame)["soft"].pixels
            assert np.array_equal(found, pixels(tmp_path / f"out.{frame}.exr")[..., :3])


@BOTH
def test_a_changed_plate_redoes_the_frames_that_read_it(own_shot, tmp_path, flow):
    graph = load(steady(own_shot, flow=flow))
    out = tmp_path / "out"
    assert done(run(graph, out)) == list(FRAMES)
    assert done(run(graph, out)) == []
    frame_file(Path(own_shot.replace("####", "1004")), 1004, seed=99)
    reach = 3 if flow else 2  # the flow of the frame two away reads one more
    assert done(run(graph, out)) == list(range(1004 - reach, 1004 + reach + 1))
    changed = files(out)
    assert run(graph, tmp_path / "new").exit_code == 0
    assert {name: pixels(tmp_path / "new" / name).tobytes() for name in changed} == {
        name: pixels(out / name).tobytes() for name in changed
    }


def test_a_new_last_frame_redoes_those_whose_window_it_completes(own_shot, tmp_path):
    graph = load(steady(own_shot))
    run(graph, tmp_path / "out")
    frame_file(Path(own_shot.replace("####", "1010")), 1010)
    assert done(run(graph, tmp_path / "out")) == [1008, 1009, 1010]


def test_a_dry_run_names_the_files_around(shot, tmp_path):
    for flow, reach in ((False, 2), (True, 3)):
        options = RunOptions(output=str(tmp_path / "out.####.exr"), frames="1005")
        (plan,) = dry_run(load(steady(shot, flow=flow)), options).plans
        assert sorted(plan.reads) == [shot.replace("####", str(f)) for f in range(1005 - reach, 1006 + reach)]


def test_a_hole_ends_the_window_or_is_an_error(own_shot, tmp_path):
    Path(own_shot.replace("####", "1004")).unlink()
    events = []
    report = run(load(steady(own_shot, missing="skip")), tmp_path / "out", on_event=events.append)
    assert report.exit_code == 0
    assert done(report) == [frame for frame in FRAMES if frame != 1004]
    told = {each["frame"]: each["text"] for each in events if each["event"] == "note" and each["node"] == "steady"}
    assert told[1003] == "frames 1004, 1005 of its window cannot be reached: the window is smaller"
    assert told[1002] == "frame 1004 of its window cannot be reached: the window is smaller"
    assert 1007 not in told
    strict = run(load(steady(own_shot, missing="skip", ends="error")), tmp_path / "strict")
    assert done(strict) == [1007]
    assert set(codes(strict).values()) == {"missing-frames"}
    assert all((each.error.node, each.error.parameter) == ("steady", "ends") for each in strict.frames if each.error)


def test_ends_changes_no_picture_and_no_key(shot, tmp_path):
    run(load(steady(shot)), tmp_path, "1004")
    assert done(run(load(steady(shot, ends="error")), tmp_path, "1004")) == []


def test_tasks_of_a_farm_are_larger_where_frames_read_others(shot, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def chunk(graph, **options):
        template = job_template(graph, RunOptions(input=shot, output=tmp_path / "out.####.exr"), **options)
        return next(each["default"] for each in template["parameterDefinitions"] if each["name"] == "ChunkSize")

    document = {"format": "flowabs.graph/1", "name": "steady", "nodes": steady(shot, flow=True)}
    (tmp_path / "steady.json").write_text(json.dumps(document), encoding="utf-8")
    assert chunk("steady.json") == 24
    assert chunk("lines") == 10
    assert chunk("steady.json", chunk=3) == 3
