"""Several runs over one sequence make each frame once, wait for each other, and all end well."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from flowabs_nodes import engine
from flowabs_nodes.engine import shared_sequence
from flowabs_nodes.io import claim_watch, file_lock
from flowabs_nodes.io.claim import claim
from flowabs_nodes.io.claim_files import HOST, claim_path
from tests.engine.sequences import document, leftovers, pixels, plate, plates, run, statuses
from tests.io.claims import holder, left_by

pytest.importorskip("fcntl")

#: Runs the graph over a sequence under a host name; says which frames it made.
WORKER = """
import json, sys
from flowabs_nodes.io import claim_files
claim_files.HOST = sys.argv[1]
from flowabs_nodes import engine
graph, shot, out, *more = map(json.loads, sys.argv[2:])
print("ready", flush=True)
sys.stdin.readline()
report = engine.run(graph, input=shot, output=out, **dict(zip(more[::2], more[1::2])))
print(json.dumps([frame.frame for frame in report.frames if frame.status == "done"]))
for frame in report.frames:
    if frame.error:
        print(frame.error, file=sys.stderr)
sys.exit(report.exit_code)
"""


def workers(count, shot, out, graph=None, **options):
    """Start runs that begin together."""
    arguments = [json.dumps(each) for each in (graph or document(), shot, out)]
    arguments += [json.dumps(each) for pair in options.items() for each in pair]
    started = [
        subprocess.Popen(
            [sys.executable, "-c", WORKER, f"node{number % 2}", *arguments], stdin=-1, stdout=-1, stderr=-1, text=True
        )
        for number in range(count)
    ]
    for each in started:
        assert each.stdout.readline() == "ready\n"
    for each in started:
        each.stdin.write("go\n")
        each.stdin.flush()
    return started


def ended(started, timeout=240):
    """Return which frames each run made; all have ended well."""
    results = [each.communicate(timeout=timeout) for each in started]
    assert [each.returncode for each in started] == [0] * len(started), [error for _, error in results]
    return [json.loads(said) for said, _ in results]


class OtherRun:
    """Another run that writes one frame, in a thread, until it is told what becomes of it."""

    def __init__(self, path, end):
        self._path, self._end = Path(path), end
        self._release, claimed = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._hold, args=(claimed,))
        self._thread.start()
        assert claimed.wait(20)

    def _hold(self, claimed):
        with claim(self._path) as held:
            claimed.set()
            self._release.wait(60)
            self._end(held)

    def finish(self):
        self._release.set()
        self._thread.join()


@pytest.fixture
def waiting(monkeypatch):
    """Return what is called when a run begins to wait."""
    called = []
    sleep = time.sleep

    def pause(seconds):
        for each in called:
            each()
        sleep(min(seconds, 0.01))

    monkeypatch.setattr(shared_sequence.time, "sleep", pause)
    return called


def shared(shot, out, **options):
    """Run, and return the report and the texts of all notes, with the frames that have ended when each was told."""
    events = []
    report = engine.run(document(), input=shot, output=out, on_event=events.append, **options)
    return report, [event["text"] for event in events if event["event"] == "note"], events


def made_elsewhere(shot, tmp_path, frame, **options):
    """Return the bytes of a frame as another run makes it."""
    elsewhere = str(tmp_path / "elsewhere" / "toon.####.exr")
    run(shot, elsewhere, frames=frame, **options)
    return Path(elsewhere.replace("####", f"{frame:04d}")).read_bytes()


@pytest.mark.parametrize("existing", ["resume", "overwrite", "error"])
def test_a_frame_of_another_run_is_left_for_last_and_counts_as_there(shot, out, tmp_path, waiting, existing):
    data = made_elsewhere(shot, tmp_path, 2)

    def publish(held):
        held.write(data)
        held.publish()

    other = OtherRun(out.replace("####", "0002"), publish)
    waiting.append(other.finish)
    report, notes, events = shared(shot, out, existing=existing)
    assert statuses(report) == [(1, "done"), (2, "skipped"), (3, "done")]
    assert report.exit_code == 0
    assert f"waiting for what other runs are writing: frame 2 by {HOST} (process {os.getpid()})" in notes
    assert "made by another run" in notes
    order = [each.get("frame") for each in events if each["event"] == "frame" or "waiting" in each.get("text", "")]
    assert order == [1, 3, None, 2], "it waits at its end"
    assert Path(out.replace("####", "0002")).read_bytes() == data
    assert not leftovers(tmp_path / "out")


def test_a_frame_that_the_other_run_failed_on_is_tried_here(shot, out, tmp_path, waiting):
    other = OtherRun(out.replace("####", "0002"), lambda held: None)
    waiting.append(other.finish)
    report, _, _ = shared(shot, out)
    assert statuses(report) == [(1, "done"), (2, "done"), (3, "done")]
    assert report.exit_code == 0


def test_overwrite_makes_what_another_run_made_of_something_else(shot, out, tmp_path, waiting):
    data = made_elsewhere(shot, tmp_path, 2, set={"stops": 3.0})

    def publish(held):
        held.write(data)
        held.publish()

    other = OtherRun(out.replace("####", "0002"), publish)
    waiting.append(other.finish)
    report, _, _ = shared(shot, out, existing="overwrite")
    assert statuses(report) == [(1, "done"), (2, "done"), (3, "done")]
    assert Path(out.replace("####", "0002")).read_bytes() != data


def test_a_claim_from_afar_is_taken_over_when_it_falls_silent(shot, out, tmp_path, waiting, monkeypatch):
    """Its host is gone; nobody sees its lock. It is touched a few times while this run waits, and then no more."""
    final = Path(out.replace("####", "0002"))
    final.parent.mkdir()
    left_by(final)
    monkeypatch.setattr(claim_watch, "SILENCE", 0.5)
    touches = []

    def touch():
        if len(touches) < 30 and claim_path(final).exists():
            touches.append(time.monotonic())
            os.utime(claim_path(final))

    waiting.append(touch)
    report, notes, _ = shared(shot, out)
    assert statuses(report) == [(1, "done"), (2, "done"), (3, "done")]
    assert time.monotonic() - touches[-1] > 0.4
    assert any("frame 2 by elsewhere (process 1)" in text for text in notes)
    assert not leftovers(tmp_path / "out")


def test_what_another_run_finished_in_between_is_not_made_twice(shot, out, tmp_path, monkeypatch):
    """It was not there when this run looked, and is when this run has the claim."""
    data = made_elsewhere(shot, tmp_path, 1)
    from flowabs_nodes.engine import render_frame as module

    def late(path, watch, root):
        Path(path).parent.mkdir(exist_ok=True)
        Path(path).write_bytes(data)
        return claim(path, watch, root)

    monkeypatch.setattr(module, "claim", late)
    report = run(shot, out, frames=1)
    assert statuses(report) == [(1, "skipped")]
    assert [timing.work for timing in report.frames[0].timings] == ["(keys)"]


def test_what_dead_runs_left_is_gone_whatever_its_frame(shot, out, tmp_path):
    (tmp_path / "out").mkdir()
    near = file_lock.reach(tmp_path / "out")
    for frame in (1, 2, 77):
        left_by(tmp_path / f"out/toon.{frame:04d}.exr", HOST, near + "ab" * 5)
    assert run(shot, out, frames="1-2").exit_code == 0
    assert not leftovers(tmp_path / "out")


def test_something_that_only_has_the_name_of_a_claim_fails_its_frame(shot, out, tmp_path):
    claim_path(tmp_path / "out/toon.0002.exr").mkdir(parents=True)
    report = run(shot, out)
    assert statuses(report) == [(1, "done"), (2, "failed"), (3, "done")]
    assert report.frames[1].error.code == "claim-blocked"


def test_many_runs_at_once(tmp_path):
    """Six, under two host names: each frame is made by exactly one of them, and each run ends well."""
    for frame in range(1, 13):
        plate(tmp_path / f"in/plate.{frame:04d}.exr", seed=frame, height=36, width=64)
    shot, out = str(tmp_path / "in/plate.####.exr"), str(tmp_path / "out/toon.####.exr")
    made = ended(workers(6, shot, out))
    assert sorted(frame for each in made for frame in each) == list(range(1, 13))
    for frame in range(1, 13):
        name = f"{frame:04d}"
        run(shot, str(tmp_path / "alone.####.exr"), frames=frame)
        np.testing.assert_array_equal(pixels(out.replace("####", name)), pixels(tmp_path / f"alone.{name}.exr"))
    assert not leftovers(tmp_path / "out")


def test_two_runs_that_overwrite_make_every_frame_and_end(tmp_path):
    shot, out = plates(tmp_path / "in", *range(1, 7)), str(tmp_path / "out/toon.####.exr")
    run(shot, out, set={"stops": 3.0})
    made = ended(workers(2, shot, out, existing="overwrite"))
    assert {frame for each in made for frame in each} == set(range(1, 7))
    assert {status for _, status in statuses(run(shot, out))} == {"skipped"}
    assert not leftovers(tmp_path / "out")


def test_a_killed_run_is_taken_over_while_another_one_waits(tmp_path):
    """One process is killed with frame 1 half done; one that waits for it makes it."""
    shot, out = plates(tmp_path / "in", 1), str(tmp_path / "out/toon.####.exr")
    final = out.replace("####", "0001")
    victim = holder(final)
    (other,) = workers(1, shot, out)
    time.sleep(1)
    assert other.poll() is None
    victim.kill()
    victim.wait()
    assert ended([other]) == [[1]]
    assert not leftovers(tmp_path / "out")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_waiting_at_once(tmp_path, number):
    shot, out = plates(tmp_path / "in", 1), str(tmp_path / "out/toon.####.exr")
    with claim(out.replace("####", "0001")):
        graph = tmp_path / "graph.json"
        graph.write_text(json.dumps(document()))
        command = [sys.executable, "-c", "from flowabs_nodes.__main__ import script; script()"]
        command += ["run", str(graph), "-i", shot, "-o", out]
        process = subprocess.Popen(command, stdout=-1, stderr=subprocess.STDOUT, text=True)
        for line in process.stdout:
            if "waiting" in line:
                break
        start = time.monotonic()
        process.send_signal(number)
        process.communicate(timeout=30)
        assert time.monotonic() - start < 3
        assert process.returncode == 128 + number
