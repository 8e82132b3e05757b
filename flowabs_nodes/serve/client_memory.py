"""Memory that a Python client shares with its server, and arrays in it."""

from __future__ import annotations

import itertools
import mmap
import os
import secrets
import sys
import tempfile
import threading
import weakref
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.errors import CommandError

#: Where a file is memory, on Linux.
_IN_MEMORY = Path("/dev/shm")

_MOST_SPARE = 6  # memories that are kept for the next pictures that lie elsewhere

#: Sends a request to the server and returns its answer; or does not wait for it.
Ask = Callable[[dict[str, Any]], dict[str, Any]]
Tell = Callable[[dict[str, Any]], None]
Bytes = npt.NDArray[np.uint8]


class Place(NamedTuple):
    """Where an array begins: the number of a shared memory, and the bytes before it."""

    memory: int
    offset: int


class Memories:
    """The memory that one connection shares, by number. It is let go with the last array in it.

    ``ask`` and ``tell`` say to the server what is shared, and what no longer is. For pictures that lie elsewhere a few
    memories are kept, those used last.
    """

    def __init__(self, ask: Ask, tell: Tell) -> None:
        self._ask, self._tell = ask, tell
        self._numbers = itertools.count(1)
        self._ranges: dict[int, range] = {}  # addresses
        self._gone: deque[int] = deque()  # filled wherever the last array of a memory happens to end
        self._spare: list[tuple[int, Bytes]] = []  # the one used last is at the end
        self._changing = threading.Lock()

    def array(self, shape: tuple[int, ...], dtype: npt.DTypeLike) -> npt.NDArray[Any]:
        """Return an array of zeros in new shared memory."""
        return np.ndarray(shape, dtype, self._new(int(np.prod(shape)) * np.dtype(dtype).itemsize)[1])

    def place(self, array: npt.NDArray[Any]) -> Place | None:
        """Return where an array lies in shared memory; None where it lies elsewhere."""
        self._let_go()
        address = array.__array_interface__["data"][0]
        with self._changing:
            found = ((number, where.start) for number, where in self._ranges.items() if address in where)
            number, start = next(found, (0, 0))
        return Place(number, address - start) if number else None

    @contextmanager
    def borrowed(self, bytes: int) -> Iterator[tuple[int, Bytes]]:
        """Give the number and the bytes of a memory that is large enough, for a picture that lies elsewhere."""
        with self._changing:
            fits = (index for index, (_, memory) in enumerate(self._spare) if bytes <= memory.size <= 2 * bytes)
            index = next(fits, None)
            spare = None if index is None else self._spare.pop(index)
        spare = self._new(bytes) if spare is None else spare
        try:
            yield spare
        finally:
            with self._changing:
                self._spare = [*self._spare, spare][-_MOST_SPARE:]

    def _new(self, bytes: int) -> tuple[int, Bytes]:
        """Return new memory that the server sees too, and its number. Raises CommandError where there is no room."""
        self._let_go()
        number = next(self._numbers)
        if sys.platform == "win32":
            name = f"flowabs-{os.getpid()}-{secrets.token_hex(8)}"
            view = mmap.mmap(-1, bytes, tagname=name)
            self._ask({"do": "map", "memory": number, "name": name, "bytes": bytes})
        else:
            descriptor, path = _file(bytes)
            try:
                view = mmap.mmap(descriptor, bytes)
                self._ask({"do": "map", "memory": number, "path": path, "bytes": bytes})
            finally:
                os.close(descriptor)
                os.unlink(path)
        memory = np.frombuffer(view, np.uint8)
        start = memory.__array_interface__["data"][0]
        with self._changing:
            self._ranges[number] = range(start, start + bytes)
        weakref.finalize(view, self._gone.append, number).atexit = False
        return number, memory

    def _let_go(self) -> None:
        """Forget memory that no array lies in any more, here and in the server."""
        while self._gone:
            with suppress(IndexError):  # another thread was first
                number = self._gone.popleft()
                with self._changing:
                    del self._ranges[number]
                self._tell({"do": "unmap", "memory": number})


def _file(bytes: int) -> tuple[int, str]:
    """Return a new file of this user alone with room for so many bytes: its descriptor and its path."""
    folders = [_IN_MEMORY] if os.access(_IN_MEMORY, os.W_OK) else []
    why = ""
    for folder in [*folders, Path(tempfile.gettempdir())]:
        try:
            descriptor, path = tempfile.mkstemp(prefix="flowabs-", dir=folder)
        except OSError as error:
            why = error.strerror or str(error)
            continue
        try:
            if hasattr(os, "posix_fallocate"):  # room that is not there is found missing now, not when it is touched
                os.posix_fallocate(descriptor, 0, bytes)
            else:
                os.ftruncate(descriptor, bytes)
            return descriptor, path
        except OSError as error:
            why = error.strerror or str(error)
            os.close(descriptor)
            with suppress(OSError):
                os.unlink(path)
    raise CommandError(f"no room for {bytes} bytes of shared memory: {why}", code="out-of-memory")
