"""Does work in a thread of its own, so that who waits for it need not wait for its end once it is cancelled."""

from __future__ import annotations

import contextvars
import threading
from collections.abc import Callable
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import Any, Generic, TypeVar

from flowabs_nodes.errors import Cancelled
from flowabs_nodes.stopping import StopFlag, stopped_by

Made = TypeVar("Made")

_HEARTBEAT = 0.2  # seconds: Windows lets Ctrl-C through only between two waits


class _Ended:
    """The last message of some work: what it returned, or raised."""

    def __init__(self, made: Any = None, error: BaseException | None = None) -> None:
        self._made, self._error = made, error

    def result(self) -> Any:
        """Return what the work returned, or raise what it raised; once."""
        made, error, self._made, self._error = self._made, self._error, None, None
        try:
            if error is not None:
                raise error
            return made
        finally:
            del error  # it knows this frame: neither is to hold the other, and the images in it


class StoppableCall(Generic[Made]):
    """Calls ``work`` once, in a thread of its own, with the context variables of the thread that made this.

    What the work tells (:meth:`tell`) is handed to ``listener`` in the thread that waits, in order.
    """

    def __init__(self, work: Callable[[], Made], listener: Callable[[Any], None]) -> None:
        self._work, self._listener = work, listener
        self._flag = StopFlag()
        self._messages: SimpleQueue[Any] = SimpleQueue()
        self._context = contextvars.copy_context()

    def tell(self, what: Any) -> None:
        """Have ``listener`` called with ``what``; any thread may call this."""
        self._messages.put(what)

    def cancel(self) -> None:
        """Ask the work to stop, and whoever waits to wait no longer; any thread may call this."""
        self._flag.set()
        self._messages.put(None)

    def result(self) -> Made:
        """Do the work, wait for it, and return what it returns, or raise what it raises.

        Raises
        ------
        Cancelled
            :meth:`cancel` was called, at whatever time. The work ends by itself, and nobody hears of it.
        """
        threading.Thread(target=self._run, name="flowabs-session", daemon=True).start()
        try:
            while True:
                with suppress(Empty):
                    message = self._messages.get(timeout=_HEARTBEAT)
                    if self._flag.number is not None:
                        raise Cancelled("cancelled")
                    if isinstance(message, _Ended):
                        return message.result()  # type: ignore[no-any-return]  # what the work returned
                    self._listener(message)
        except BaseException:  # Ctrl-C in this thread, or a listener's error: nobody waits any more
            self._flag.set()
            raise

    def _run(self) -> None:
        """Do the work and tell how it ended."""
        try:
            ended = _Ended(made=self._context.run(self._stoppable))
        except BaseException as error:  # noqa: BLE001 - raised again by whoever waits
            ended = _Ended(error=error)
        if self._flag.number is None:  # else nobody asks, and the images may go
            self._messages.put(ended)
        del ended, self._work  # which know this frame and this call, and are large

    def _stoppable(self) -> Made:
        """Do the work where it looks at the flag."""
        with stopped_by(self._flag):
            return self._work()
