"""A claim is touched for as long as it is held, by one thread."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from flowabs_nodes.io import heartbeat
from flowabs_nodes.io.claim import claim
from flowabs_nodes.io.claim_files import claim_path
from flowabs_nodes.io.heartbeat import Heartbeat


class Counted:
    """Something that counts how often it was touched."""

    def __init__(self, fails: bool = False) -> None:
        self.touches = 0
        self.fails = fails
        self.abandoned = False

    def touch(self) -> None:
        self.touches += 1
        if self.fails:
            raise OSError("gone")

    def abandon(self) -> None:
        self.abandoned = True


def until(true: Callable[[], bool]) -> bool:
    deadline = time.monotonic() + 20
    while not true() and time.monotonic() < deadline:
        time.sleep(0.01)
    return true()


@pytest.fixture(autouse=True)
def often(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(heartbeat, "INTERVAL", 0.01)


def test_one_thread_touches_all_until_there_are_none() -> None:
    heart = Heartbeat()
    one, two = Counted(fails=True), Counted()
    before = threading.active_count()
    heart.add(one)
    heart.add(two)
    assert threading.active_count() == before + 1
    assert until(lambda: one.touches > 2 and two.touches > 2)
    heart.remove(one)
    touches = one.touches
    assert until(lambda: two.touches > 10)
    assert one.touches == touches
    heart.remove(two)
    assert until(lambda: not heart.beats)
    heart.add(one)
    assert until(lambda: one.touches > touches), "it begins anew"
    heart.remove(one)


def test_both_files_of_a_claim_are_touched(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(heartbeat, "HEARTBEAT", Heartbeat())
    monkeypatch.setattr("flowabs_nodes.io.claim.HEARTBEAT", heartbeat.HEARTBEAT)
    final = tmp_path / "out.exr"
    with claim(final) as held:
        for path in (claim_path(final), held.temporary):
            os.utime(path, (0, 0))
            assert until(lambda path=path: os.stat(path).st_mtime > 1e9)  # type: ignore[misc]
        held.write(b"frame")
        held.publish()
        os.utime(final, (0, 0))
        time.sleep(0.1)
        assert os.stat(final).st_mtime == 0, "the frame's own time is left alone"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")
def test_a_fork_has_a_heartbeat_of_its_own() -> None:
    heart = Heartbeat()
    parents = Counted()
    heart.add(parents)
    child = os.fork()
    if child == 0:
        own = Counted()
        quiet = parents.abandoned and not heart.beats
        heart.add(own)
        alive = until(lambda: own.touches > 1)
        os._exit(0 if quiet and alive else 1)
    assert os.waitpid(child, 0)[1] == 0
    touches = parents.touches
    assert until(lambda: parents.touches > touches)
    assert not parents.abandoned
    heart.remove(parents)


def test_no_more_threads_is_no_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(thread: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    heart = Heartbeat()
    with monkeypatch.context() as patched:
        patched.setattr(threading.Thread, "start", refuse)
        heart.add(Counted())
        assert not heart.beats
    other = Counted()
    heart.add(other)
    assert until(lambda: other.touches > 0)
