import os
import signal
import subprocess
import sys
import threading
import time

import pytest

from flowabs_nodes import signals, stopping
from flowabs_nodes.signals import interruptible, stop_on_signals

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no such signals")

BOTH = pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])


def wait_until(happened, seconds=10.0):
    end = time.monotonic() + seconds
    while not happened() and time.monotonic() < end:
        time.sleep(0.005)
    assert happened()


@BOTH
def test_a_signal_sets_the_flag_and_raises_nothing(number, code):
    before = signal.getsignal(number)
    with stop_on_signals():
        stopping.check()
        os.kill(os.getpid(), number)
        wait_until(lambda: stopping.any_set(stopping.flags()))
        with pytest.raises(stopping.Stopped) as stopped:
            stopping.check()
    assert stopped.value.exit_code == code
    assert signal.getsignal(number) is before
    stopping.check()


def test_inside_of_another_one_nothing_changes():
    with stop_on_signals():
        handler = signal.getsignal(signal.SIGINT)
        with stop_on_signals():
            assert signal.getsignal(signal.SIGINT) is handler
        assert signal.getsignal(signal.SIGINT) is handler


def test_in_another_thread_handlers_stay_as_they_are():
    seen = []

    def look():
        with stop_on_signals(), interruptible():
            seen.append(signal.getsignal(signal.SIGTERM))
            seen.append(signal.getsignal(signal.SIGINT))

    before = [signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)]
    thread = threading.Thread(target=look)
    thread.start()
    thread.join()
    assert seen == before


def test_a_signal_that_is_ignored_stays_ignored():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with stop_on_signals():
            os.kill(os.getpid(), signal.SIGHUP)
            time.sleep(0.05)
            stopping.check()
    finally:
        signal.signal(signal.SIGHUP, before)


def process(code):
    code = f"import ctypes, os, signal, sys, time\nfrom flowabs_nodes import signals, stopping\n{code}"
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "ready\n"
    return child


#: A library's call that does not come back, and during which Python's own handlers never run.
STUCK = """
signals.GRACE = {grace}
signals.before_the_end.append(lambda: os.write(1, b"cleaned\\n"))
with signals.stop_on_signals():
    print("ready", flush=True)
    libc = ctypes.CDLL(None)
    while True:
        libc.sleep(60)
"""


@BOTH
def test_a_second_signal_ends_a_process_that_is_stuck(number, code):
    child = process(STUCK.format(grace=60))
    child.send_signal(number)
    time.sleep(0.2)
    assert child.poll() is None
    child.send_signal(signal.SIGINT)
    out, err = child.communicate(timeout=10)
    assert (child.returncode, out, err) == (code, "cleaned\n", "flowabs: asked to stop twice: ended now\n")


def test_one_signal_ends_it_after_a_while():
    child = process(STUCK.format(grace=0.3))
    child.send_signal(signal.SIGTERM)
    out, err = child.communicate(timeout=10)
    assert (child.returncode, out) == (143, "cleaned\n")
    assert "still at work 0.3 s after" in err


@BOTH
def test_work_of_which_nothing_is_lost_is_broken_off_sooner(number, code):
    sooner = "signals.PATIENCE = 0.3\nstopping.may_be_broken_off.append(lambda: {})\n"
    child = process(sooner.format(True) + STUCK.format(grace=60))
    child.send_signal(number)
    out, err = child.communicate(timeout=10)
    assert (child.returncode, out) == (code, "cleaned\n")
    assert "while a kernel was compiled" in err
    other = process(sooner.format(False) + STUCK.format(grace=60))
    other.send_signal(number)
    with pytest.raises(subprocess.TimeoutExpired):
        other.communicate(timeout=1.5)
    other.kill()
    other.communicate()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_to_a_child_of_a_fork_ends_the_child_alone(number):
    """As multiprocessing ends its processes, in a node that uses it."""
    with stop_on_signals():
        child = os.fork()
        if child == 0:
            try:
                time.sleep(60)
            finally:
                os._exit(3 if signal.getsignal(number) is signal.default_int_handler else 4)
        time.sleep(0.1)
        os.kill(child, number)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) in (-number, 3)
        time.sleep(0.2)
        assert not stopping.any_set(stopping.flags())


def test_ctrl_c_in_python_waits_for_a_place_where_work_may_end():
    places = []

    def work():
        os.kill(os.getpid(), signal.SIGINT)
        places.append("not in the middle of anything")
        stopping.check()
        places.append("never here")

    with pytest.raises(KeyboardInterrupt), interruptible():
        work()
    assert places == ["not in the middle of anything"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    stopping.check()


def test_a_second_ctrl_c_in_python_is_pythons_own():
    def work():
        os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(10)

    with pytest.raises(KeyboardInterrupt) as interrupt, interruptible():
        work()
    assert not isinstance(interrupt.value, stopping.Stopped)


def test_ctrl_c_when_all_is_done_is_not_lost():
    with pytest.raises(stopping.Stopped), interruptible():
        os.kill(os.getpid(), signal.SIGINT)


def test_who_handles_ctrl_c_already_goes_on_to():
    seen = []
    before = signal.signal(signal.SIGINT, lambda number, frame: seen.append(number))
    try:
        with interruptible():
            os.kill(os.getpid(), signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, before)
    assert seen == [signal.SIGINT]
    assert signals.GRACE > 5
