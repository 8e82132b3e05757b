"""Does work in a thread for which Blender does not wait: with progress, notes, and an end within moments when asked."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from flowabs_nodes.engine.error_boundary import error_boundary
from flowabs_nodes.errors import Cancelled
from flowabs_nodes.simd import compile_hooks
from flowabs_nodes.stopping import StopFlag, Stopped, stopped_by

Made = TypeVar("Made")

#: All that is at work, to be ended with the extension or the file.
_at_work: set[Background[Any]] = set()


class Background(Generic[Made]):
    """Calls ``work(self)`` once, in a thread of its own. The work may not touch ``bpy``.

    Attributes
    ----------
    progress
        How much is done, 0 to 1.
    text
        What is at work, for the status bar.
    compiling
        Whether kernels had to be compiled, which can take a minute, once on a machine.
    notes
        What the work had to say: ("note", text) or ("warning", text).
    """

    def __init__(self, work: Callable[[Background[Made]], Made]) -> None:
        self.progress = 0.0
        self.text = ""
        self.compiling = False
        self.notes: list[tuple[str, str]] = []
        self._work = work
        self._flag = StopFlag()
        self._made: Any = None
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="flowabs-blender", daemon=True)

    def start(self) -> Background[Made]:
        """Begin, and return this."""
        _at_work.add(self)
        if _tell_compiling not in compile_hooks.waiting:
            compile_hooks.waiting.append(_tell_compiling)
        self._thread.start()
        return self

    @property
    def running(self) -> bool:
        """Return whether the work goes on."""
        return self._thread.is_alive()

    @property
    def cancelled(self) -> bool:
        """Return whether somebody has asked the work to end."""
        return self._flag.number is not None

    def cancel(self) -> None:
        """Ask the work to end; filters stop within tens of milliseconds, a library's call goes on to its end."""
        self._flag.set()

    def wait(self, seconds: float | None = None) -> bool:
        """Wait for the end, that long at most; return whether it has come. Ctrl-C cancels the work."""
        end = None if seconds is None else time.monotonic() + seconds
        try:
            while self.running and (end is None or time.monotonic() < end):
                self._thread.join(0.05)
        except KeyboardInterrupt:
            self.cancel()
            raise
        return not self.running

    def result(self) -> Made:
        """Return what the ended work has made, or raise what it raised; Cancelled where it was asked to end."""
        if self._error is not None:
            raise self._error
        return self._made  # type: ignore[no-any-return]

    def hear(self, event: dict[str, Any]) -> None:
        """Take an event of a run (docs/running.md) as progress, text or note."""
        match event["event"]:
            case "start":
                self.text = f"{event['frames']} frames"
            case "node" if event["status"] == "started":
                self.text = f"frame {event['frame']}: {event['node']}"
            case "note":
                text = f"{event['node']}: {event['text']}" if event["node"] else event["text"]
                self.notes.append((event["level"], text))
        if "percent" in event:
            self.progress = event["percent"] / 100
        elif "progress" in event:
            self.progress = event["progress"]

    def warn(self, text: str) -> None:
        """Take a warning."""
        self.notes.append(("warning", text))

    def _run(self) -> None:
        try:
            with stopped_by(self._flag), error_boundary():
                self._made = self._work(self)
        except Stopped:
            self._error = Cancelled("cancelled")
        except BaseException as error:  # noqa: BLE001 - raised again by whoever asks for the result
            self._error = error
        finally:
            del self._work  # which may hold large pictures
            _at_work.discard(self)


def _tell_compiling() -> None:
    """Let all that is at work know that kernels are compiled."""
    for work in at_work():
        work.compiling = True


def at_work() -> tuple[Background[Any], ...]:
    """Return all that is at work."""
    return tuple(_at_work)


def end_all(seconds: float = 2.0) -> None:
    """Have all work end, and wait so long for it at most."""
    end = time.monotonic() + seconds
    works = at_work()
    for work in works:
        work.cancel()
    for work in works:
        work.wait(max(0.0, end - time.monotonic()))
