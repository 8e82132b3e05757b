"""Forks wait for what other threads hold, and never for ever."""

import os
import threading
import time

import pytest

from flowabs_nodes import forks

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")


@pytest.fixture
def lock(monkeypatch):
    monkeypatch.setattr(forks, "_guarded", list(forks._guarded))
    held = threading.Lock()
    forks.take_before(held)
    return held


def child(work):
    """Fork; return what ``work()`` is in the child, True or False."""
    pid = os.fork()
    if pid == 0:
        os._exit(0 if work() else 1)
    return os.waitpid(pid, 0)[1] == 0


def holding(lock, seconds):
    """Have another thread hold a lock for some seconds, and wait until it does."""
    begun = threading.Event()

    def hold():
        with lock:
            begun.set()
            time.sleep(seconds)

    thread = threading.Thread(target=hold)
    thread.start()
    assert begun.wait(10)
    return thread


def test_a_lock_is_free_in_the_child_and_afterwards(lock):
    thread = holding(lock, 0.5)
    assert child(lambda: lock.acquire(timeout=5))
    thread.join()
    assert lock.acquire(timeout=5)


def test_a_fork_waits_while_another_thread_imports():
    thread = holding(forks.IMPORTING, 0.5)
    began = time.monotonic()
    assert child(lambda: forks.IMPORTING.acquire(timeout=5))
    assert time.monotonic() - began > 0.2
    thread.join()


def test_locks_are_taken_in_any_order(lock):
    """Another thread takes the second lock first, and then the first one."""
    other = threading.Lock()
    forks.take_before(other)
    got = []

    def hold_and_take():
        with other:
            begun.set()
            time.sleep(0.3)
            got.append(lock.acquire(timeout=5))
        lock.release()

    begun = threading.Event()
    thread = threading.Thread(target=hold_and_take)
    thread.start()
    assert begun.wait(10)
    assert child(lambda: lock.acquire(timeout=5) and other.acquire(timeout=5))
    thread.join()
    assert got == [True]


def test_a_fork_goes_on_where_a_lock_is_never_free(lock, monkeypatch):
    monkeypatch.setattr(forks, "PATIENCE", 0.3)
    with lock:
        assert child(lambda: not lock.acquire(timeout=0.2) and forks.IMPORTING.acquire(timeout=5))
