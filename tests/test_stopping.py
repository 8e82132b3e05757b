import signal
import threading

import pytest

from flowabs_nodes import stopping
from flowabs_nodes.stopping import StopFlag, Stopped


def test_work_is_stopped_by_its_own_flag_only():
    mine, others = StopFlag(), StopFlag()
    with stopping.stopped_by(mine):
        others.set()
        stopping.check()
        mine.set()
        with pytest.raises(Stopped):
            stopping.check()
        assert mine.told
    stopping.check()


def test_work_inside_of_work_is_stopped_by_both():
    outer, inner = StopFlag(), StopFlag()
    with stopping.stopped_by(outer), stopping.stopped_by(inner):
        outer.set()
        with pytest.raises(Stopped):
            stopping.check()


def test_the_first_signal_counts():
    flag = StopFlag()
    flag.set(signal.SIGTERM)
    flag.set(signal.SIGINT)
    with pytest.raises(Stopped, match="SIGTERM") as stopped:
        flag.check()
    assert stopped.value.exit_code == 143


def test_it_is_never_taken_for_a_failure():
    assert not issubclass(Stopped, Exception)
    assert issubclass(Stopped, KeyboardInterrupt)


def test_the_flag_of_the_process_is_seen_by_every_thread_and_new_afterwards():
    seen = []

    def look():
        seen.append(stopping.any_set(stopping.flags()))

    with stopping.process_flag() as flag:
        flag.set()
        thread = threading.Thread(target=look)
        thread.start()
        thread.join()
    look()
    assert seen == [True, False]
