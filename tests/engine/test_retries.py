"""Frames are rendered again after a failure of the system that may pass, and after no other."""

import errno
import os
import threading
import time

import pytest

from flowabs_nodes import engine, file_hash
from flowabs_nodes.engine import retries
from flowabs_nodes.errors import InternalError, ReadError, WriteError
from flowabs_nodes.io import claim
from flowabs_nodes.stopping import StopFlag, Stopped, stopped_by
from tests.engine.sequences import graph_around, leftovers, run, statuses


@pytest.fixture
def failing(monkeypatch):
    """Let hashing a plate, or writing, fail with an errno so many times; return how often it was tried."""
    monkeypatch.setattr(retries, "PAUSE", 0.01)

    def fail(number, times, where="read"):
        tried = []

        def before(name):
            tried.append(name)
            if len(tried) <= times:
                raise OSError(number, os.strerror(number), str(name))

        if where == "read":
            known = file_hash.file_version
            monkeypatch.setattr(file_hash, "file_version", lambda path: before(path) or known(path))
        else:
            write = claim.Claim.write
            monkeypatch.setattr(claim.Claim, "write", lambda self, data: before(self.final) or write(self, data))
        return tried

    return fail


@pytest.mark.parametrize("name", ["EIO", "ESTALE", "ETIMEDOUT", "EAGAIN", "EBUSY", "ENETDOWN", "ECONNRESET"])
@pytest.mark.parametrize("where", ["read", "write"])
def test_a_failure_that_passes_costs_no_frame(shot, out, tmp_path, failing, name, where):
    failing(getattr(errno, name), 1, where)
    report = run(shot, out, frames=1)
    assert statuses(report) == [(1, "done")]
    told = [str(note) for note in report.frames[0].notes if note.warning]
    assert len(told) == 1
    assert os.strerror(getattr(errno, name)) in told[0]
    assert "rendered again after" in told[0]
    assert not leftovers(tmp_path / "out")


def test_not_more_often_than_asked_for(shot, out, failing):
    tried = failing(errno.EIO, 100, "write")
    assert statuses(run(shot, out, frames=1, retries=3)) == [(1, "failed")]
    assert len(tried) == 4
    tried.clear()
    assert statuses(run(shot, out, frames=1, retries=0)) == [(1, "failed")]
    assert len(tried) == 1


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EACCES, errno.ENOENT, errno.EISDIR])
def test_what_does_not_pass_is_not_tried_again(shot, out, failing, number):
    tried = failing(number, 100, "write")
    assert statuses(run(shot, out, frames=1, retries=3)) == [(1, "failed")]
    assert len(tried) == 1


def test_bad_data_is_not_tried_again(shot, out):
    runs = []

    def wrong(context, image):
        runs.append(context.frame)
        raise ValueError("nothing to see")

    report = engine.run(graph_around(wrong), input=shot, output=out, frames=1, retries=5)
    assert statuses(report) == [(1, "failed")]
    assert runs == [1]


def test_what_counts_as_passing():
    for error in (ReadError("damaged"), InternalError("?"), WriteError("x"), None, OSError("no number")):
        assert retries.passing_failure(error) is None
    error = WriteError("x")
    error.__cause__ = failure = OSError(errno.ESTALE, "stale")
    assert retries.passing_failure(error) is failure


def test_a_pause_ends_when_the_run_is_to_stop(monkeypatch):
    flag = StopFlag()
    threading.Timer(0.1, flag.set).start()
    start = time.monotonic()
    with stopped_by(flag), pytest.raises(Stopped):
        retries._wait(30)
    assert time.monotonic() - start < 5
