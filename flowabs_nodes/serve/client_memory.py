"""Memory that a Python client shares with its server, and arrays in it."""

from __future__ import annotations

import itertools
import mmap
import os
import secrets
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.errors import CommandError

#: Where a file is memory, on Linux.
_IN_MEMORY = Path("/dev/shm")

#: Sends a request to the server and returns its answer.
Ask = Callable[[dict[str, Any]], dict[str, Any]]


class Place(NamedTuple):
    """Where an array begins: the number of a shared memory, and the bytes before it."""

    memory: int
    offset: int


class Memories:
    """The memory that one connection shares, by number; ``ask`` tells the server of it.

    Memory for pictures that lie elsewhere is kept for the next ones of that size.
    """

    def __init__(self, ask: Ask) -> None:
        self._ask = ask
        self._numbers = itertools.count(1)
        self._shared: dict[int, npt.NDArray[np.uint8]] = {}
        self._spare: dict[int, list[int]] = {}  # numbers of memory that nobody uses, by bytes
        self._changing = threading.Lock()

    def array(self, shape: tuple[int, ...], dtype: npt.DTypeLike) -> npt.NDArray[Any]:
        """Return an array of zeros in new shared memory."""
        result = np.ndarray(shape, dtype, self._shared[self._new(int(np.prod(shape)) * np.dtype(dtype).itemsize)])
        result.fill(0)
        return result

    def place(self, array: npt.NDArray[Any]) -> Place | None:
        """Return where an array lies in shared memory; None where it lies elsewhere."""
        address = array.__array_interface__["data"][0]
        for number, memory in tuple(self._shared.items()):
            start = memory.__array_interface__["data"][0]
            if start <= address < start + len(memory):
                return Place(number, address - start)
        return None

    @contextmanager
    def borrowed(self, bytes: int) -> Iterator[tuple[int, npt.NDArray[np.uint8]]]:
        """Give the number and the bytes of a memory of that size, for a picture that lies elsewhere."""
        with self._changing:
            spare = self._spare.get(bytes)
            number = spare.pop() if spare else None
        number = self._new(bytes) if number is None else number
        try:
            yield number, self._shared[number]
        finally:
            with self._changing:
                self._spare.setdefault(bytes, []).append(number)

    def _new(self, bytes: int) -> int:
        """Return the number of new memory that the server sees too. Raises CommandError where there is no room."""
        memory = next(self._numbers)
        if sys.platform == "win32":
            name = f"flowabs-{os.getpid()}-{secrets.token_hex(8)}"
            view = mmap.mmap(-1, bytes, tagname=name)
            self._ask({"do": "map", "memory": memory, "name": name, "bytes": bytes})
        else:
            descriptor, path = _file(bytes)
            try:
                view = mmap.mmap(descriptor, bytes)
                self._ask({"do": "map", "memory": memory, "path": path, "bytes": bytes})
            finally:
                os.close(descriptor)
                os.unlink(path)
        with self._changing:
            self._shared[memory] = np.frombuffer(view, np.uint8)
        return memory


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
