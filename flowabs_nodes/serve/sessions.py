"""The sessions of all clients: each is used by one render at a time, and those unused longest are let go."""

from __future__ import annotations

import os
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from flowabs_nodes import stopping
from flowabs_nodes.engine.compiler import load_compiler
from flowabs_nodes.engine.memory import give_back_freed_memory
from flowabs_nodes.engine.runnable import load_graph
from flowabs_nodes.engine.session import Session
from flowabs_nodes.errors import Cancelled
from flowabs_nodes.graph.shipped import resolve
from flowabs_nodes.image import Image
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.simd.bands import available_threads

_PATIENCE = 0.02  # seconds between two looks at whether a render that waits for its turn was cancelled

#: A session's name: the number of the client's connection, and what the client calls it.
Name = tuple[int, str]
Tell = Callable[[dict[str, Any]], None]


class HeldSession:
    """A session under a client's name, of a graph whose file may change.

    Attributes
    ----------
    users
        How many renders use it, or wait for their turn.
    gone
        Whether it was let go: who waits for its turn waits in vain.
    """

    def __init__(self, make: Callable[..., Session]) -> None:
        self.users, self.gone = 0, False
        self._make = make
        self._turn = threading.Lock()
        self._changing = threading.Lock()
        self._session: Session | None = None
        self._loaded: tuple[object, ...] = ()
        self._values: Mapping[str, Any] = {}
        self._given: dict[str, Image] = {}
        self._tell: Tell | None = None
        self._cancelled: object = None  # the flag of the render that is at work

    @contextmanager
    def turn(self, flag: stopping.StopFlag, tell: Tell) -> Iterator[None]:
        """Wait for a render's turn; inside, ``tell`` is told what the session does, and :meth:`cancel` stops it."""
        wait_for(self._turn)
        try:
            with self._changing:
                self._tell, self._cancelled = tell, flag
            yield
        finally:
            with self._changing:
                self._tell = self._cancelled = None
            self._turn.release()

    def cancel(self, flag: stopping.StopFlag) -> None:
        """Have the render of this flag, if it is at work, raise Cancelled at once."""
        with self._changing:
            session = self._session if self._cancelled is flag else None
        if session is not None:
            session.cancel()

    def ready(self, source: str, values: Mapping[str, Any]) -> Session:
        """Return the session with the graph as its file is now, and just these values set.

        Raises FlowabsError for a graph that cannot be loaded and for wrong values; the session stays as it was.
        """
        stamp = _stamp(source)
        if self._session is None or stamp != self._loaded:
            made = self._make(load_graph(source), on_event=self._event)
            self.close()
            with self._changing:
                self._session, self._loaded, self._values, self._given = made, stamp, {}, {}
        session = self._session
        assert session is not None
        if self.gone:
            raise Cancelled("the session was let go")
        if values != self._values:
            self._values = {"": None}  # what the session stands at is not known if one of the next two raises
            session.reset()
            session.set(values)
            self._values = dict(values)
        return session

    def give(self, session: Session, images: Mapping[str, Image]) -> None:
        """Give the session these pictures and no others."""
        pictures: dict[str, Any] = {**dict.fromkeys(self._given), **images}
        session.given(pictures)
        self._given = dict(images)

    @property
    def bytes(self) -> int:
        """Return how many bytes of results and pictures are held."""
        given = sum(image.pixels.nbytes for image in tuple(self._given.values()))
        return given + (self._session.cached_bytes if self._session is not None else 0)

    def close(self) -> None:
        """Let go of results and pictures, and cancel what is at work."""
        with self._changing:
            session, self._session, self._given = self._session, None, {}
        if session is not None:
            session.close()

    def _event(self, event: dict[str, Any]) -> None:
        tell = self._tell
        if tell is not None:
            tell(event)


class Sessions:
    """Holds the sessions of all clients.

    Parameters
    ----------
    most
        How many there may be; of those that are not in use the one unused longest goes first.
    cache_bytes
        The most bytes of results and pictures of all together, looked at after each render; one alone may hold so many
        results.
    threads
        How many threads a filter uses, and how many renders are at work at once; None: as many as processors. The
        kernels of all renders share one pool of threads, each render has one of its own beside.
    settings
        How pictures are read.
    """

    def __init__(self, most: int, cache_bytes: int, threads: int | None, settings: Settings) -> None:
        self._most, self._cache_bytes = most, cache_bytes
        self._held: OrderedDict[Name, HeldSession] = OrderedDict()  # the one used last is at the end
        self._changing = threading.Lock()
        self._at_work = threading.BoundedSemaphore(max(2, threads or available_threads()))

        def make(graph: Any, on_event: Tell) -> Session:
            return Session(graph, cache_bytes=cache_bytes, threads=threads, settings=settings, on_event=on_event)

        self._make = make

    @contextmanager
    def using(self, name: Name) -> Iterator[HeldSession]:
        """Hold a session while a render uses it or waits for it; it is made if it is not there."""
        with self._changing:
            held = self._held.setdefault(name, HeldSession(self._make))
            held.users += 1
            self._held.move_to_end(name)
        try:
            yield held
        finally:
            with self._changing:
                held.users -= 1
            self._let_go()

    @contextmanager
    def at_work(self) -> Iterator[None]:
        """Wait until fewer renders are at work than there may be, or until this one is asked to stop."""
        wait_for(self._at_work)
        try:
            load_compiler()  # pictures are converted by kernels too
            yield
        finally:
            self._at_work.release()

    def forget(self, client: int, name: str | None = None) -> None:
        """Let go of a client's session, or of all of them; what is at work there is cancelled."""
        with self._changing:
            names = [each for each in self._held if each[0] == client and name in (None, each[1])]
            gone = [self._held.pop(each) for each in names]
        for held in gone:
            held.gone = True
            held.close()
        if gone:
            give_back_freed_memory()

    def _let_go(self) -> None:
        """Let go of the sessions unused longest, while there are too many, or too many bytes."""
        gone = []
        with self._changing:
            bytes = {name: held.bytes for name, held in self._held.items()}
            idle = [name for name, held in self._held.items() if not held.users]
            newest = next(reversed(self._held), None)
            for name in idle:
                too_many = len(self._held) > self._most
                if too_many or (sum(bytes.values()) > self._cache_bytes and name != newest):
                    gone.append(self._held.pop(name))
                    del bytes[name]
        for held in gone:
            held.close()


def wait_for(lock: Any) -> None:
    """Acquire a lock or a semaphore. Raises Stopped where the work is asked to stop before."""
    while not lock.acquire(timeout=_PATIENCE):
        stopping.check()


def _stamp(source: str) -> tuple[object, ...]:
    """Return what changes when the file of a graph does; CommandError for a name that no graph has."""
    path = resolve(source)
    try:
        found = os.stat(path)
    except (OSError, ValueError):  # what loads it tells why
        return (str(path), None)
    return (str(path), found.st_mtime_ns, found.st_size, found.st_ino)
