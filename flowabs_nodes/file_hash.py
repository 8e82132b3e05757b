"""Hash the bytes of files, each version of a file once."""

from __future__ import annotations

import hashlib
import os
import threading

from flowabs_nodes import forks

#: A cache: (real path, size, time of change) -> hash.
_known: dict[tuple[str, int, int], str] = {}
_lock = threading.Lock()
forks.take_before(_lock)


def file_hash(path: str | os.PathLike[str]) -> str:
    """Return the BLAKE2b-256 of a file's bytes, as 64 hexadecimal digits. Raises OSError where it cannot be read.

    A file whose path, size and time are those of an earlier call is not read again.
    """
    before = file_version(path)
    with _lock:
        if before in _known:
            return _known[before]
    with open(path, "rb") as file:
        digest = hashlib.file_digest(file, lambda: hashlib.blake2b(digest_size=32)).hexdigest()
    if file_version(path) == before:  # not while somebody writes it
        with _lock:
            _known[before] = digest
    return digest


def file_version(path: str | os.PathLike[str]) -> tuple[str, int, int]:
    """Return what changes when a file does: (real path, size in bytes, time of change in ns)."""
    state = os.stat(path)
    return os.path.realpath(path), state.st_size, state.st_mtime_ns
