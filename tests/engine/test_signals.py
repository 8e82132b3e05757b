import os
import signal
import threading

import pytest

from flowabs_nodes.engine.signals import Stopped, stop_on_signals


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_inside_is_raised_and_the_old_handler_comes_back(number, code):
    before = signal.getsignal(number)
    with pytest.raises(Stopped) as stopped, stop_on_signals():
        os.kill(os.getpid(), number)
    assert stopped.value.exit_code == code
    assert not isinstance(stopped.value, Exception), "nothing takes it for a failure"
    assert signal.getsignal(number) is before


def test_in_another_thread_handlers_stay_as_they_are():
    seen = []

    def look():
        with stop_on_signals():
            seen.append(signal.getsignal(signal.SIGTERM))

    before = signal.getsignal(signal.SIGTERM)
    thread = threading.Thread(target=look)
    thread.start()
    thread.join()
    assert seen == [before]
