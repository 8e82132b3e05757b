"""When frames go to other processes, and that it makes no difference to what comes out."""

import os

import OpenImageIO as oiio
import pytest

from flowabs_nodes.engine import render_frames as module
from flowabs_nodes.engine.worker_pool import WorkerPool
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.simd import bands
from tests.engine.sequences import document, graph_around, leftovers, pixels, plates, run, statuses

FRAMES = range(1, 7)
ALL_DONE = [(frame, "done") for frame in FRAMES]


@pytest.fixture
def shot(tmp_path):
    return plates(tmp_path / "in", *FRAMES)


@pytest.fixture
def in_processes(monkeypatch):
    """The frames that were given to other processes."""
    given = []
    render = WorkerPool.render

    def noting(self, numbers):
        given.extend(numbers)
        return render(self, numbers)

    monkeypatch.setattr(WorkerPool, "render", noting)
    return given


def test_frames_in_other_processes_are_the_same(shot, tmp_path, in_processes):
    here, there = tmp_path / "here", tmp_path / "there"
    assert statuses(run(shot, str(here / "o.####.exr"), jobs=1)) == ALL_DONE
    assert not in_processes
    events = []
    assert statuses(run(shot, str(there / "o.####.exr"), jobs=2, on_event=events.append)) == ALL_DONE
    assert in_processes == list(FRAMES)
    for frame in FRAMES:
        name = f"o.{frame:04}.exr"
        assert pixels(here / name).tobytes() == pixels(there / name).tobytes()
    assert not leftovers(there)
    worked = {(event["frame"], event["node"]) for event in events if event["event"] == "node"}
    assert {(frame, node) for frame in FRAMES for node in ("plate", "out")} <= worked
    assert [event["percent"] for event in events if event["event"] == "frame"][-1] == 100


def test_without_a_number_they_go_there_once_two_frames_say_that_it_pays(shot, tmp_path, in_processes, monkeypatch):
    monkeypatch.setattr(module, "WORTH", 0.0)
    out = str(tmp_path / "out/o.####.exr")
    assert statuses(run(shot, out, threads=2)) == ALL_DONE
    assert in_processes == [3, 4, 5, 6]
    del in_processes[:]
    assert {status for _, status in statuses(run(shot, out, threads=2))} == {"skipped"}
    assert not in_processes, "to look at what is there takes no time"


def test_the_libraries_keep_to_the_threads_of_the_run(shot, tmp_path):
    before, seen = oiio.get_int_attribute("threads"), set()

    def look(context, image):
        seen.add((bands.thread_count(), oiio.get_int_attribute("threads"), oiio.get_int_attribute("exr_threads")))
        return image

    run(shot, str(tmp_path / "out/o.####.exr"), graph_around(look), threads=3)
    assert seen == {(3, 3, 3)}
    assert oiio.get_int_attribute("threads") == before


def test_little_work_stays_here(shot, tmp_path, in_processes):
    assert statuses(run(shot, str(tmp_path / "out/o.####.exr"))) == ALL_DONE
    assert not in_processes


@pytest.mark.parametrize("options", [{}, {"jobs": 2}, {"timeout": 60}])
def test_nodes_that_a_script_made_up_stay_here_and_what_that_means_is_said(shot, tmp_path, in_processes, options):
    seen = []

    def look(context, image):
        seen.append(context.frame)
        return image

    events = []
    report = run(shot, str(tmp_path / "out/o.####.exr"), graph_around(look), on_event=events.append, **options)
    assert statuses(report) == ALL_DONE
    assert seen == list(FRAMES)
    warned = [event["text"] for event in events if event["event"] == "note" and event["level"] == "warning"]
    assert sum("rendered in this process" in text for text in warned) == (1 if options else 0)
    assert not in_processes


def test_a_frame_that_fails_there_fails_as_it_would_here(shot, tmp_path):
    os.truncate(shot.replace("####", "0003"), 200)
    reports = [run(shot, str(tmp_path / f"{jobs}/o.####.exr"), jobs=jobs) for jobs in (1, 2)]
    assert [report.exit_code for report in reports] == [1, 1]
    here, there = (report.frames[2].error for report in reports)
    assert (type(here), str(here), here.to_dict()) == (type(there), str(there), there.to_dict())
    assert [(frame.frame, frame.status) for frame in reports[1].frames if frame.status == "failed"] == [(3, "failed")]


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("jobs", 0),
        ("jobs", 1.5),
        ("jobs", True),
        ("threads", -1),
        ("retries", -1),
        ("retries", None),
        ("timeout", 0),
        ("timeout", "soon"),
        ("timeout", True),
        ("memory", "much"),
        ("memory", "-1G"),
        ("memory", 5),
    ],
)
def test_what_cannot_be_is_named(shot, tmp_path, option, value):
    with pytest.raises(ArgumentError, match=rf"{option}: expected .* found {value!r}") as caught:
        run(shot, str(tmp_path / "o.####.exr"), document(), **{option: value})
    assert caught.value.parameter == option
