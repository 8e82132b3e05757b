"""Frames in other processes: the same pixels, and what happens when a process is lost, late, or takes too much."""

import os
import signal
import sys
from itertools import islice

import pytest

from flowabs_nodes import stopping
from flowabs_nodes.engine.job_builder import build_job
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.engine.run_events import RunEvents
from flowabs_nodes.engine.runnable import load_graph
from flowabs_nodes.engine.worker_pool import SETTLED, Limits, WorkerPool
from flowabs_nodes.engine.worker_process import WorkerProcess
from tests.engine.sequences import leftovers, pixels, plate

FRAMES = range(1, 7)


@pytest.fixture
def job(tmp_path):
    for frame in FRAMES:
        plate(tmp_path / f"in.{frame:04}.exr", seed=frame)
    asked = RunOptions(input=tmp_path / "in.####.exr", output=tmp_path / "out.####.exr")
    return build_job(load_graph("lines"), asked)[0]


def pool(job, notes=None, peak=1, chunk=1, **limits):
    known = {"jobs": 2, "threads": 2, "memory": 10**12} | limits

    def listen(event):
        if event["event"] == "note" and notes is not None:
            notes.append(event["text"])

    types = {name: node.declaration.type for name, node in job.graph.nodes.items()}
    return WorkerPool(job, Limits(**known), RunEvents(listen, types), peak=peak, chunk=chunk)


def statuses(reports):
    return sorted((report.frame, report.status) for report in reports)


def gone(*processes):
    return all(process.poll() is not None for process in processes)


def test_every_frame_is_rendered_once_and_no_process_is_left(job, tmp_path):
    here = pool(job)
    generator = here.render(FRAMES)
    first = next(generator)
    processes = [worker.process for worker in here._workers]
    assert len(processes) == 2
    assert statuses([first, *generator]) == [(frame, "done") for frame in FRAMES]
    assert gone(*processes)
    made = {pixels(tmp_path / f"out.{frame:04}.exr").tobytes() for frame in FRAMES}
    assert len(made) == len(FRAMES)
    assert not leftovers(tmp_path)


def test_a_process_that_is_killed_costs_no_frame(job, tmp_path):
    notes = []
    here = pool(job, notes)
    generator = here.render(FRAMES)
    reports = [next(generator)]
    here._workers[0].process.kill()
    reports += generator
    assert statuses(reports) == [(frame, "done") for frame in FRAMES]
    assert not [note for note in notes if "GB" in note]
    assert not leftovers(tmp_path)


def test_a_process_that_the_system_kills_beside_others_leaves_fewer_at_a_time(job):
    notes = []
    here = pool(job, notes)
    reports = []
    for report in here.render(FRAMES):
        reports.append(report)
        busy = here._busy()
        if len(reports) == 1 and len(busy) > 1:
            busy[0].process.send_signal(signal.SIGKILL)
    assert statuses(reports) == [(frame, "done") for frame in FRAMES]
    assert here._jobs == 1 or not notes


def test_a_process_that_ends_on_every_try_fails_its_frame_only(job, monkeypatch):
    notes = []
    here = pool(job, notes, jobs=1, retries=2)
    tries = 0

    def kill(worker, message):
        nonlocal tries
        if getattr(message, "frames", ()) == (2,):
            tries += 1
            worker.process.kill()  # none is beside it: it is not for want of memory
            worker.process.wait()

    monkeypatch.setattr("flowabs_nodes.engine.worker_process.WorkerProcess.ask", asked_after(kill))
    reports = list(here.render(FRAMES))
    assert statuses(reports) == [(frame, "failed" if frame == 2 else "done") for frame in FRAMES]
    error = next(report.error for report in reports if report.error)
    assert (error.code, error.frame) == ("worker-lost", 2)
    assert tries == 3
    assert len([note for note in notes if "rendered again" in note]) == 2


def asked_after(act):
    ask = WorkerProcess.ask

    def both(worker, message):
        act(worker, message)
        ask(worker, message)

    return both


def test_a_frame_that_takes_too_long_is_ended_and_told(job, tmp_path):
    notes = []
    reports = list(pool(job, notes, timeout=1e-6, retries=1).render([1, 2]))
    assert statuses(reports) == [(1, "failed"), (2, "failed")]
    assert {report.error.code for report in reports} == {"timeout"}
    assert "took longer than 1e-06 s" in str(reports[0].error)
    assert "--timeout" in reports[0].error.hint
    assert not [name for name in os.listdir(tmp_path) if name.startswith("out.")]


@pytest.mark.parametrize(("memory", "at_once"), [(10**12, 2), (6 * 10**9, 2), (3 * 10**9, 1)])
def test_as_many_at_once_as_fit(job, memory, at_once):
    here = pool(job, peak=2 * 10**9, memory=memory)
    seen = [len(here._busy()) + 1 for _ in islice(here.render(FRAMES), 4)]
    assert max(seen) == at_once


def test_frames_that_read_their_neighbours_are_expected_to_take_more_at_first(job, tmp_path):
    here = pool(job, peak=2 * 10**9, memory=6 * 10**9, chunk=3)
    seen = [len(here._busy()) for _ in here.render(range(1, 13))]
    assert max(seen[:SETTLED]) == 1
    assert seen[SETTLED:] != [1] * len(seen[SETTLED:])


def test_a_frame_that_needs_more_than_all_is_rendered_alone_and_a_line_says_so(job):
    notes = []
    here = pool(job, notes, peak=2 * 10**9, memory=10**9)
    assert len(list(here.render(FRAMES))) == len(FRAMES)
    assert [note for note in notes if "2.00 GB" in note and "(1.00 GB)" in note and "one at a time" in note]
    assert len(notes) == 1


def test_the_first_frame_is_rendered_alone_and_measured(job):
    here = pool(job, peak=0)
    generator = here.render(FRAMES)
    next(generator)
    assert here.peak > 10**7
    assert len(here._workers) == 2
    assert len(list(generator)) == len(FRAMES) - 1


def test_a_run_that_is_stopped_ends_its_processes(job, tmp_path):
    flag = stopping.StopFlag()
    here = pool(job)
    generator = here.render(FRAMES)

    def all_of_it():
        for _ in generator:
            processes.extend(worker.process for worker in here._workers)
            flag.set(signal.SIGTERM)

    processes = []
    with stopping.stopped_by(flag), pytest.raises(stopping.Stopped):
        all_of_it()
    assert processes
    assert gone(*processes)
    assert not leftovers(tmp_path)


def test_frames_that_nobody_has_begun_can_be_dropped(job):
    here = pool(job, jobs=1)
    generator = here.render(FRAMES)
    reports = [next(generator)]
    dropped = here.drop_waiting()
    reports += generator
    assert sorted([*dropped, *(report.frame for report in reports)]) == list(FRAMES)
    assert len(dropped) >= 4


@pytest.mark.skipif(sys.platform != "linux", reason="looks at /proc")
def test_what_a_worker_reports_is_its_own_peak(job):
    here = pool(job, peak=0, jobs=1)
    list(here.render([1]))
    assert 10**7 < here.peak < 4 * 10**9
