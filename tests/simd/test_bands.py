import os
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flowabs_nodes import stopping
from flowabs_nodes.simd import bands

PACKAGE = Path(bands.__file__).parents[2]


@given(height=st.integers(1, 500), count=st.integers(1, 5), least=st.integers(1, 64))
def test_bands_are_all_rows_once_in_order(height, count, least):
    with bands.limited(count):
        found = bands.over_rows(lambda *band: band, height, least=least)
    assert [row for first, last in found for row in range(first, last)] == list(range(height))
    assert len(found) == 1 or min(last - first for first, last in found) >= least


def test_a_band_gets_the_arguments():
    with bands.limited(2):
        assert set(bands.over_rows(lambda first, last, *rest: rest, 40, "picture", 3)) == {("picture", 3)}


def test_several_threads_work_at_once():
    meeting = threading.Barrier(3, timeout=30)
    with bands.limited(3):
        names = bands.over_rows(lambda first, last: meeting.wait() and threading.current_thread().name, 3, least=1)
    assert len(names) == 3


@pytest.mark.parametrize("count", [1, 2, 3])
def test_an_error_in_any_band_comes_out_when_no_band_is_at_work(count):
    running = set()

    def kernel(first, last):
        running.add(first)
        try:
            if last > 30:
                raise ZeroDivisionError(f"rows {first} to {last}")
        finally:
            running.remove(first)

    for _ in range(20):
        with bands.limited(count), pytest.raises(ZeroDivisionError, match="rows"):
            bands.over_rows(kernel, 60, least=1)
        assert not running
    with bands.limited(count):
        assert sum(bands.over_rows(lambda first, last: last - first, 60)) == 60


def test_after_an_error_no_other_band_begins():
    begun = []

    def kernel(first, last):
        begun.append(first)
        raise KeyboardInterrupt

    with bands.limited(2), pytest.raises(KeyboardInterrupt):
        bands.over_rows(kernel, 160, least=1)
    assert len(begun) <= 4


@pytest.mark.parametrize("count", [1, 2, 3])
def test_who_is_asked_to_stop_ends_after_the_bands_at_work(count):
    flag, begun, running = stopping.StopFlag(), [], set()

    def kernel(first, last):
        begun.append(first)
        running.add(first)
        flag.set()
        running.remove(first)

    with bands.limited(count), stopping.stopped_by(flag), pytest.raises(stopping.Stopped):
        bands.over_rows(kernel, 240, least=1)
    assert 1 <= len(begun) <= count
    assert not running
    with stopping.stopped_by(flag), pytest.raises(stopping.Stopped):
        bands.over_rows(lambda first, last: begun.clear(), 240)
    assert begun


def test_the_limit_is_that_of_the_block_and_of_the_thread():
    with bands.limited(5):
        assert bands.thread_count() == 5
        with bands.limited(0):
            assert bands.thread_count() == 1
        assert bands.thread_count() == 5
        with ThreadPoolExecutor(1) as pool:
            assert pool.submit(bands.thread_count).result() == bands.available_threads()
    assert bands.thread_count() == bands.available_threads()


def test_python_threads_may_all_call_kernels_at_once():
    def total(number):
        with bands.limited(3):
            return sum(bands.over_rows(lambda first, last: sum(range(first, last)) * number, 300, least=1))

    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(total, range(100))) == [number * 300 * 299 // 2 for number in range(100)]


def test_nobody_waits_for_helpers_that_are_busy_elsewhere():
    inside, over = threading.Event(), threading.Event()

    def slow(first, last):
        inside.set()
        assert over.wait(60)

    def blocked():
        with bands.limited(2):
            bands.over_rows(slow, 2, least=1)

    other = threading.Thread(target=blocked)
    other.start()
    assert inside.wait(60)
    with bands.limited(2):
        assert len(bands.over_rows(lambda first, last: last, 64, least=1)) == 16
    over.set()
    other.join()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_a_child_of_a_fork_has_threads_of_its_own():
    code = """
import os, sys
from flowabs_nodes import stopping
from flowabs_nodes.simd import bands
def total():
    with bands.limited(3):
        return sum(bands.over_rows(lambda first, last: last - first, 300, least=1))
assert total() == 300
child = os.fork()
if child == 0:
    os._exit(0 if total() == 300 else 1)
sys.exit(os.waitpid(child, 0)[1])
"""
    use = {**os.environ, "PYTHONPATH": str(PACKAGE)}
    assert (
        subprocess.run([sys.executable, "-W", "ignore", "-c", code], env=use, timeout=60, check=False).returncode == 0
    )


@pytest.fixture
def every(monkeypatch):
    """How many threads there are on a machine of 16 processors."""

    def ask(granted, **environment):
        monkeypatch.delenv("NUMBA_NUM_THREADS", raising=False)
        for name, value in environment.items():
            monkeypatch.setenv(name, value)
        monkeypatch.setattr(os, "process_cpu_count", lambda: 16, raising=False)
        monkeypatch.setattr(bands, "_granted", lambda: granted)
        return bands.available_threads.__wrapped__()

    return ask


def test_as_many_threads_as_processors_that_the_process_may_use(every):
    assert every(np.inf) == 16
    assert every(2.5) == 3
    assert every(0.1) == 1
    assert every(np.inf, NUMBA_NUM_THREADS="5") == 5
    assert every(np.inf, NUMBA_NUM_THREADS="0") == every(np.inf, NUMBA_NUM_THREADS="many") == 16


@pytest.mark.parametrize(
    ("own", "files", "expected"),
    [
        ("0::/\n", {"cpu.max": "250000 100000\n"}, 2.5),
        ("0::/a/b\n", {"cpu.max": "max 100000", "a/cpu.max": "400000 100000", "a/b/cpu.max": "800000 100000"}, 4),
        ("0::/not/seen/from/inside\n", {"cpu.max": "50000 100000"}, 0.5),
        (
            "5:memory:/m\n4:cpu,cpuacct:/a\n0::/\n",
            {"cpu/a/cpu.cfs_quota_us": "150000\n", "cpu/a/cpu.cfs_period_us": "50000\n"},
            3,
        ),
        ("1:cpu:/\n", {"cpu/cpu.cfs_quota_us": "-1", "cpu/cpu.cfs_period_us": "100000"}, np.inf),
        ("0::/\n", {"cpu.max": "max 100000"}, np.inf),
        ("0::/\n", {}, np.inf),
        ("", {}, np.inf),
    ],
)
def test_what_a_container_grants(tmp_path, own, files, expected):
    (tmp_path / "own").write_text(own)
    for name, content in files.items():
        file = tmp_path / "groups" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(content)
    assert bands._granted(tmp_path / "groups", tmp_path / "own") == expected


def test_where_there_are_no_control_groups(tmp_path):
    assert bands._granted(tmp_path, tmp_path / "none") == np.inf


_SUMS = """
import threading
from flowabs_nodes.simd import bands

def total():
    with bands.limited(4):
        return sum(bands.over_rows(lambda first, last: last - first, 300))
"""


@pytest.mark.parametrize(
    "code",
    [
        # As the last line of a script: the main thread ends while, or before, the bands run.
        "threading.Thread(target=lambda: (time.sleep(0.3), print(total()))).start()",
        "atexit.register(lambda: print(total()))",
        "total(); atexit.register(lambda: print(total()))",
        "threading.Thread(target=lambda: (total(), time.sleep(0.3), print(total()))).start()",
        'def refuse(self): raise RuntimeError("can\'t start new thread")\n'
        "threading.Thread.start = refuse\nprint(total())",
    ],
)
def test_where_no_thread_can_be_had_the_bands_run_in_this_one(code):
    use = {**os.environ, "PYTHONPATH": str(PACKAGE)}
    code = f"import atexit, time\n{_SUMS}\n{code}"
    done = subprocess.run(
        [sys.executable, "-c", code], env=use, timeout=60, check=False, capture_output=True, text=True
    )
    assert (done.stdout, done.stderr) == ("300\n", "")


def test_a_thread_that_could_not_be_started_does_no_work_after_its_call_has_returned(monkeypatch):
    """The pool's queue keeps what it was asked for when a thread cannot start."""
    calls = []
    start = threading.Thread.start

    def refuse(thread):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", refuse)
    with bands.limited(7):
        bands.over_rows(lambda first, last: calls.append(first), 700)
    monkeypatch.setattr(threading.Thread, "start", start)
    before = len(calls)
    with bands.limited(7):
        results = bands.over_rows(lambda first, last: last - first, 700)
    assert sum(results) == 700
    assert len(calls) == before
