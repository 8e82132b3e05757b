"""Hash the content of files: a part of every key, so that a plate that changed is filtered again."""

from __future__ import annotations

import hashlib
import os
import threading

from flowabs_nodes.errors import ReadError
from flowabs_nodes.io import formats

#: A cache: (real path, size, time of change) -> hash.
_known: dict[tuple[str, int, int], str] = {}
_lock = threading.Lock()


def content_hash(path: str | os.PathLike[str]) -> str:
    """Return the BLAKE2b-256 of a file's bytes, as 64 hexadecimal digits. Raises ReadError where it cannot be read.

    What is no file (a folder, a pipe, a device) is refused at once. A file whose path, size and time are those of an
    earlier call is not read again.
    """
    formats.check_kind(path)
    try:
        before = _version(path)
        with _lock:
            if before in _known:
                return _known[before]
        with open(path, "rb") as file:
            digest = hashlib.file_digest(file, lambda: hashlib.blake2b(digest_size=32)).hexdigest()
        if _version(path) == before:  # not while somebody writes it
            with _lock:
                _known[before] = digest
    except FileNotFoundError:
        raise ReadError("no such file", code="missing-file", file=os.fspath(path)) from None
    except (OSError, ValueError) as error:
        raise ReadError(f"cannot be read: {error}", file=os.fspath(path)) from error
    return digest


def _version(path: str | os.PathLike[str]) -> tuple[str, int, int]:
    """Return what changes when a file does: (real path, size in bytes, time of change in ns)."""
    state = os.stat(path)
    return os.path.realpath(path), state.st_size, state.st_mtime_ns
