"""Frames on workers of Dask: the same pixels and events, and what happens when a worker or the scheduler is lost."""

import os
import signal
import subprocess
import threading
import time

import pytest

from flowabs_nodes import graph as graphs
from flowabs_nodes import stopping
from flowabs_nodes.engine import dask_pool, dask_presence
from flowabs_nodes.engine.dask_cluster import DaskCluster
from flowabs_nodes.engine.dask_worker import Place
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.engine.report import FrameReport
from flowabs_nodes.engine.run_events import RunEvents
from flowabs_nodes.errors import WriteError
from flowabs_nodes.nodes import catalogue
from tests.engine.dask_nodes import trouble
from tests.engine.sequences import document, leftovers, pixels, plates, run, statuses
from tests.engine.windows import MEAN

pytest.importorskip("distributed", reason="the extra dask is not installed")

from tests.engine.dask_farm import Farm

FRAMES = range(1, 7)
ALL_DONE = [(frame, "done") for frame in FRAMES]


@pytest.fixture
def shot(tmp_path):
    return plates(tmp_path / "in", *FRAMES)


@pytest.fixture(scope="module")
def shared_farm(tmp_path_factory):
    """A scheduler with two workers, which no test ends."""
    farm = Farm(tmp_path_factory.mktemp("farm"))
    farm.worker()
    farm.worker()
    yield farm
    farm.end()


@pytest.fixture
def farm(tmp_path):
    """A scheduler without workers, for tests that end them."""
    folder = tmp_path / "farm"
    folder.mkdir()
    farm = Farm(folder)
    yield farm
    farm.end()


def children(process):
    """Return the processes that render frames for a worker."""
    import psutil

    return [each for each in psutil.Process(process.pid).children() if "flowabs_nodes" in " ".join(each.cmdline())]


def eventually(true, seconds=20):
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end
        time.sleep(0.05)


class Heard(list):
    """The events of a run; ``when`` calls a function at the first event of a kind."""

    def __init__(self, kind="", act=None):
        super().__init__()
        self.kind, self.act = kind, act

    def __call__(self, event):
        self.append(event)
        if self.act and event["event"] == self.kind:
            act, self.act = self.act, None
            act()

    def texts(self):
        return [event["text"] for event in self if event["event"] == "note"]


def kinds(events):
    """Return what was told of each frame, whatever the time and the order of frames."""
    told = sorted(
        (event["frame"], event["event"], event.get("node") or "", event.get("status") or "", event.get("text") or "")
        for event in events
        if event["event"] in ("node", "frame", "detail", "profile")
    )
    return [each for each in told if "(" not in each[2]]


@pytest.mark.slow
def test_frames_on_dask_are_the_same_and_so_is_what_is_told(shot, tmp_path, shared_farm):
    found = {}
    for name, options in {
        "here": {"jobs": 1},
        "processes": {"jobs": 2},
        "local": {"scheduler": "local", "jobs": 2},
        "tcp": {"scheduler": shared_farm.address},
    }.items():
        events = Heard()
        report = run(shot, str(tmp_path / name / "o.####.exr"), profile=True, on_event=events, **options)
        assert statuses(report) == ALL_DONE, report.frames
        made = [pixels(tmp_path / name / f"o.{frame:04}.exr").tobytes() for frame in FRAMES]
        found[name] = (made, events[0]["event"], kinds(events_without(events, name, tmp_path)))
        assert events[-1]["event"] == "end"
        assert [event["percent"] for event in events if event["event"] == "frame"][-1] == 100
        assert {each.node for each in report.profile} == {"plate", "bright", "out", "(keys)"}
        assert not leftovers(tmp_path / name)
    assert found["local"] == found["tcp"] == found["processes"] == found["here"]
    assert not any(children(worker) for worker in shared_farm.processes[1:]), "processes are left"


def events_without(events, name, folder):
    return [{**event, "text": event.get("text", "").replace(str(folder / name), "")} for event in events]


def test_names_are_those_of_where_the_run_was_started(shot, tmp_path, shared_farm, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert statuses(run("in/plate.####.exr", "out/o.####.exr", scheduler=shared_farm.address)) == ALL_DONE
    assert len(list((tmp_path / "out").iterdir())) == len(FRAMES)


def test_a_second_run_keeps_what_is_there(shot, tmp_path, shared_farm):
    out = str(tmp_path / "out/o.####.exr")
    run(shot, out, jobs=1)
    assert {status for _, status in statuses(run(shot, out, scheduler=shared_farm.address))} == {"skipped"}
    os.unlink(tmp_path / "out/o.0003.exr")
    events = Heard()
    again = run(shot, out, scheduler=shared_farm.address, on_event=events)
    assert dict(statuses(again)) == {frame: "done" if frame == 3 else "skipped" for frame in FRAMES}
    report = run(shot, out, scheduler=shared_farm.address, existing="error")
    assert {frame.error.code for frame in report.frames} == {"exists"}


def test_a_frame_that_fails_there_fails_as_it_would_here(shot, tmp_path, shared_farm):
    os.truncate(shot.replace("####", "0003"), 200)
    here = run(shot, str(tmp_path / "here/o.####.exr"), jobs=1)
    there = run(shot, str(tmp_path / "there/o.####.exr"), scheduler=shared_farm.address)
    assert there.exit_code == 1
    errors = [report.frames[2].error for report in (here, there)]
    assert len({(type(error), str(error)) for error in errors}) == 1
    assert sum(frame.status == "done" for frame in there.frames) == 5


def test_neighbours_go_to_one_worker(shot, tmp_path, shared_farm, monkeypatch):
    sent = []
    send = dask_pool.DaskPool._send

    def noting(self, frames, *others):
        sent.append(frames)
        send(self, frames, *others)

    monkeypatch.setattr(dask_pool.DaskPool, "_send", noting)
    mean = {"bright": {"type": "mean@1", "inputs": {"image": "plate"}, "params": {"radius": 1}}}
    graph = graphs.load(document(**mean), catalogue() | {"mean": MEAN})
    assert statuses(run(shot, str(tmp_path / "o.####.exr"), graph, scheduler=shared_farm.address)) == ALL_DONE
    assert sent == [(1, 2, 3), (4, 5, 6)]


def test_a_frame_that_takes_too_long_is_ended_with_its_process(shot, tmp_path, shared_farm):
    events = Heard()
    out = str(tmp_path / "out/o.####.exr")
    report = run(
        shot,
        out,
        trouble(seconds=600),
        scheduler=shared_farm.address,
        frames="1-2",
        timeout=4,
        retries=0,
        on_event=events,
    )
    assert {frame.error.code for frame in report.frames} == {"timeout"}
    assert "took longer than 4 s" in str(report.frames[0].error)
    assert report.seconds < 30
    assert not leftovers(tmp_path / "out")
    assert not any(children(worker) for worker in shared_farm.processes[1:])


@pytest.mark.parametrize("scheduler", ["local", "tcp"])
def test_a_run_that_is_stopped_takes_its_frames_back(shot, tmp_path, shared_farm, scheduler):
    flag = stopping.StopFlag()
    address = shared_farm.address if scheduler == "tcp" else "local"
    events = Heard("node", lambda: flag.set(signal.SIGTERM))
    with stopping.stopped_by(flag):
        report = run(shot, str(tmp_path / "out/o.####.exr"), trouble(seconds=600), scheduler=address, on_event=events)
    assert report.exit_code == 143
    assert not [path for path in leftovers(tmp_path) if path.parent.name != "farm"]
    assert not any(children(worker) for worker in shared_farm.processes[1:])
    assert not [thread for thread in threading.enumerate() if thread.name == "flowabs-worker"]


@pytest.mark.slow
def test_a_worker_that_is_killed_costs_no_frame(shot, tmp_path, farm):
    workers = [farm.worker(), farm.worker()]
    events = Heard("node", workers[0].kill)
    report = run(shot, str(tmp_path / "out/o.####.exr"), trouble(seconds=0.5), scheduler=farm.address, on_event=events)
    assert statuses(report) == ALL_DONE, [frame.error for frame in report.frames]
    assert not leftovers(tmp_path / "out")
    workers[0].wait()


@pytest.mark.slow
def test_a_frame_that_ends_every_worker_fails_and_ends_no_more_than_it_may(shot, tmp_path, farm):
    farm.worker("--nanny")
    farm.worker("--nanny")
    events = Heard()
    report = run(shot, str(tmp_path / "out/o.####.exr"), trouble(deadly=2), scheduler=farm.address, on_event=events)
    assert dict(statuses(report)) == {frame: "failed" if frame == 2 else "done" for frame in FRAMES}
    assert (report.exit_code, report.frames[1].error.code) == (1, "worker-lost")
    assert len([text for text in events.texts() if "was lost: rendered again" in text]) == 1
    eventually(lambda: not leftovers(tmp_path / "out"))  # the last process learns after the run that its worker is gone


@pytest.mark.slow
def test_a_scheduler_that_is_lost_fails_what_is_left_and_nothing_hangs(shot, tmp_path, farm):
    worker = farm.worker()
    events = Heard("frame", farm.scheduler.kill)
    report = run(shot, str(tmp_path / "out/o.####.exr"), trouble(seconds=0.5), scheduler=farm.address, on_event=events)
    assert report.exit_code == 1
    assert {frame.error.code for frame in report.frames if frame.error} == {"scheduler-lost"}
    assert report.frames[0].status == "done"
    assert report.seconds < 40
    try:
        worker.wait(60)
    except subprocess.TimeoutExpired:
        pytest.fail("the worker lives on")
    eventually(lambda: not leftovers(tmp_path / "out"))


@pytest.mark.slow
def test_where_no_worker_is_left_the_run_waits_and_goes_on_with_the_next(shot, tmp_path, farm):
    worker = farm.worker()

    def lose():
        worker.kill()
        threading.Timer(4, farm.worker).start()

    events = Heard("node", lose)
    report = run(shot, str(tmp_path / "out/o.####.exr"), trouble(seconds=0.2), scheduler=farm.address, on_event=events)
    assert statuses(report) == ALL_DONE, [frame.error for frame in report.frames]
    assert any("no worker is left" in text for text in events.texts())


@pytest.mark.slow
def test_where_no_worker_comes_any_more_the_frames_fail(shot, tmp_path, farm, monkeypatch):
    monkeypatch.setattr(dask_presence, "ALONE", 1.0)
    worker = farm.worker()
    events = Heard("node", worker.kill)
    report = run(shot, str(tmp_path / "out/o.####.exr"), trouble(seconds=5), scheduler=farm.address, on_event=events)
    assert {frame.error.code for frame in report.frames} == {"no-worker"}


def test_a_frame_that_a_lost_worker_still_claims_is_asked_for_again_for_a_while(monkeypatch):
    pool = dask_pool.DaskPool(None, RunOptions(), RunEvents(None, {}))
    claimed = FrameReport(3, "failed", error=WriteError("by somebody", code="claimed"))
    assert not pool._postponed(claimed), "another run's"
    pool._lost[3] = 1
    assert pool._postponed(claimed)
    assert pool.drop_waiting() == (3,)
    assert not pool._postponed(FrameReport(3, "done"))
    monkeypatch.setattr(dask_pool, "SILENCE", -11.0)
    assert not pool._postponed(claimed), "somebody lives who writes it"


@pytest.mark.parametrize(
    ("memory", "peak", "jobs", "at_once"),
    [(None, 0, None, 2), (None, 10**9, None, 6), (None, 3 * 10**9, None, 3), (10**9, 10**9, None, 2), (None, 1, 4, 4)],
)
def test_as_many_at_once_as_fit_on_each_worker(memory, peak, jobs, at_once):
    cluster = object.__new__(DaskCluster)
    cluster.local, cluster._memory = False, memory
    refused = Place("c", 8, 10**12, "has no flowabs-nodes")
    cluster.places = {"a": Place("a", 4, 8 * 10**9), "b": Place("b", 2, 4 * 10**9), "c": refused}
    assert cluster.room(peak, jobs) == at_once
