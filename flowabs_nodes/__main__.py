"""``python -m flowabs_nodes`` and ``flowabs``: the command line."""

from __future__ import annotations

import signal
import sys


def script() -> None:
    """Run the command line, and end the process.

    Signals are listened to before anything is imported that takes time, and until the process has ended.
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # until then Ctrl-C ends it without a traceback
    from flowabs_nodes.signals import stop_on_signals

    with stop_on_signals():
        from flowabs_nodes.cli import run_process

        run_process()


def main(*words: str) -> None:
    """Run the command line on these words, and end the process: for :mod:`flowabs_nodes.engine.child_python`."""
    sys.argv[1:] = words
    script()


if __name__ == "__main__":
    script()
