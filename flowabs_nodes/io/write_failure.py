"""Tell why a file cannot be written, before it is tried and after."""

from __future__ import annotations

import errno
import os
import secrets
import stat
from pathlib import Path

from flowabs_nodes.errors import WriteError
from flowabs_nodes.io.claim_files import HOST

_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


def failure(error: OSError, path: str | os.PathLike[str]) -> WriteError:
    """Return the WriteError that an OSError while writing means: code "disk-full", "unwritable" or "write-failed"."""
    name = os.fspath(path)
    if error.errno in (errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC)):
        return WriteError("no space is left on the disk", code="disk-full", file=name)
    if error.errno in (errno.EACCES, errno.EPERM, errno.EROFS):
        return WriteError("its folder is not writable", code="unwritable", file=name)
    return WriteError(f"cannot be written: {error.strerror or error}", file=name)


def check_replaceable(path: str | os.PathLike[str]) -> None:
    """Raise WriteError for what no frame may replace: a folder, a pipe, a device. A symbolic link is replaced itself.

    Raises OSError for a name that no file can have.
    """
    try:
        mode = os.lstat(path).st_mode
    except (FileNotFoundError, NotADirectoryError):
        return
    for is_kind, what in _KINDS:
        if is_kind(mode):
            raise WriteError(f"there is {what} of this name", code="not-a-file", file=os.fspath(path))


def check_writable(folder: str | os.PathLike[str]) -> None:
    """Raise WriteError where no file could be made in ``folder``, or in the nearest folder above that exists."""
    place = _nearest(folder)
    probe = place / f".flowabs.{HOST}.{secrets.token_hex(8)}.probe"
    try:
        os.close(os.open(probe, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600))
        os.unlink(probe)
    except OSError as error:
        raise failure(error, folder) from error


def check_access(folder: str | os.PathLike[str]) -> None:
    """Raise WriteError as :func:`check_writable` does, from permissions alone: nothing is made, not for a moment."""
    place = _nearest(folder)
    if not place.is_dir():
        raise failure(NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR)), folder)
    if not os.access(place, os.W_OK | os.X_OK):
        raise failure(PermissionError(errno.EACCES, os.strerror(errno.EACCES)), folder)


def _nearest(folder: str | os.PathLike[str]) -> Path:
    """Return a folder, or the nearest one above it that exists."""
    place = Path(folder)
    while not place.exists() and place != place.parent:
        place = place.parent
    return place
