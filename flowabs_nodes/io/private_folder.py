"""Gives a folder for a moment, for libraries that write to files only, and tells when there is no space in it.

It is made where ``TMPDIR`` says, which is often another disk, and a small one, than that of the outputs.
"""

from __future__ import annotations

import errno
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager

from flowabs_nodes.errors import WriteError

_NO_SPACE = frozenset(getattr(errno, name) for name in ("ENOSPC", "EDQUOT", "EFBIG") if hasattr(errno, name))
_CURE = "TMPDIR names another folder for what is encoded"


@contextmanager
def private_folder() -> Iterator[str]:
    """Make a folder, and remove it at the end with all that is in it.

    Raises
    ------
    WriteError
        disk-full or unwritable, where it cannot be made.
    """
    try:
        made = tempfile.TemporaryDirectory(prefix="flowabs-")
    except OSError as error:  # FileNotFoundError, where no folder that Python knows of takes a file
        where = os.environ.get("TMPDIR") or "the folders for temporary files"
        if error.errno in _NO_SPACE:
            raise no_space_in(where) from error
        what = f"no temporary file can be made in {where}: {error.strerror or error}"
        raise WriteError(what, code="unwritable", hint=_CURE) from error
    with made as folder:
        yield folder


def no_space_in(folder: str) -> WriteError:
    """Return the error of a picture that could not be encoded since there is no space in ``folder``."""
    return WriteError(f"no space is left in {folder}, the folder for temporary files", code="disk-full", hint=_CURE)


def is_full(path: str, more: int = 1 << 16) -> bool:
    """Return True where a file in a private folder cannot grow by ``more`` bytes: disk, quota or limit is reached."""
    try:
        with open(path, "ab", buffering=0) as file:
            left = memoryview(bytes(more))
            while left:
                left = left[file.write(left) :]
    except OSError as error:
        return error.errno in _NO_SPACE
    return False
