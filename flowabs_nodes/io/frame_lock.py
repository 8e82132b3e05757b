"""Claim a frame before it is written, so that two runs never write one file.

A claim is a temporary file beside the frame, opened exclusively and locked. Its name, ``.{name}.{host}.{pid}.tmp``,
says who writes. While the writer lives nobody else writes that frame. When the writer is killed the system drops the
lock, and the next writer sweeps the temporary away. The final name only ever holds a whole frame.
"""

from __future__ import annotations

import errno
import importlib
import os
import re
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from flowabs_nodes.errors import WriteError
from flowabs_nodes.io.sequences import Sequence

fcntl: Any
try:
    fcntl = importlib.import_module("fcntl")
except ImportError:  # Windows: a claim lives as long as it is young
    fcntl = None

#: Seconds after which a claim whose writer cannot be seen from here (another host) counts as dead.
STALE_AFTER = 24 * 3600.0

HOST = re.sub(r"[^A-Za-z0-9_-]", "-", socket.gethostname()) or "localhost"
_BLOCK = 1 << 24
_CLAIM = re.compile(r"\.(?P<name>.+)\.(?P<host>[A-Za-z0-9_-]+)\.(?P<pid>\d{1,10})\.tmp", re.DOTALL)


class ClaimedError(WriteError):
    """Somebody else is writing this frame."""

    code = "claimed"


class Claim:
    """The right to write one file: ``temporary`` is where its bytes go first."""

    def __init__(self, final: Path, temporary: Path, fd: int) -> None:
        self.final = final
        self.temporary = temporary
        self._fd: int | None = fd

    def write(self, data: bytes | memoryview) -> None:
        """Write every byte of ``data`` to the temporary; all are on disk when this returns. Raises OSError."""
        assert self._fd is not None
        rest = memoryview(data)
        while rest:
            rest = rest[os.write(self._fd, rest) :]  # a write may be short
        os.fsync(self._fd)

    def holds(self, data: bytes | memoryview) -> bool:
        """Read the temporary back, and return True if it is ``data``, byte for byte."""
        expected = memoryview(data)
        place = 0
        with open(self.temporary, "rb") as file:
            while block := file.read(_BLOCK):
                if expected[place : place + len(block)] != block:
                    return False
                place += len(block)
        return place == len(expected)

    def publish(self) -> None:
        """Give the temporary its final name, in one step; a symbolic link there is replaced, not followed."""
        if fcntl is None:  # Windows renames no file that is open
            self._close()
        os.replace(self.temporary, self.final)
        _sync_folder(self.final.parent)

    def release(self) -> None:
        """Remove the temporary where it has not been published, and let others claim the frame."""
        if fcntl is None:
            self._close()
        # Removed while it is still locked: nobody else can have this name in between.
        with suppress(FileNotFoundError):
            os.unlink(self.temporary)
        self._close()

    def _close(self) -> None:
        """Close the temporary, which drops the lock."""
        if self._fd is not None:
            os.close(self._fd)
            self._fd = None


@contextmanager
def claim(path: str | os.PathLike[str]) -> Iterator[Claim]:
    """Claim the file ``path``, and make its folder. The temporary is removed at the end unless it has been published.

    Raises ClaimedError where somebody else is writing it, WriteError where its folder cannot be written.
    """
    final = Path(path)
    try:
        final.parent.mkdir(parents=True, exist_ok=True)
        if final.is_dir() and not final.is_symlink():
            raise WriteError("there is a folder of this name", file=str(final))
        taken = Claim(final, *_take(final))
    except OSError as error:
        raise failure(error, final) from error
    try:
        yield taken
    finally:
        taken.release()


def failure(error: OSError, path: str | os.PathLike[str]) -> WriteError:
    """Return the WriteError that an OSError while writing means: code "disk-full", "unwritable" or "write-failed"."""
    name = os.fspath(path)
    if error.errno in (errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC)):
        return WriteError("no space is left on the disk", code="disk-full", file=name)
    if error.errno in (errno.EACCES, errno.EPERM, errno.EROFS):
        return WriteError("its folder is not writable", code="unwritable", file=name)
    return WriteError(f"cannot be written: {error.strerror or error}", file=name)


def check_writable(folder: str | os.PathLike[str]) -> None:
    """Raise WriteError where no file could be made in ``folder``, or in the nearest folder above that exists."""
    place = Path(folder)
    while not place.exists() and place != place.parent:
        place = place.parent
    probe = place / f".flowabs.{HOST}.{os.getpid()}.{time.monotonic_ns()}.probe"
    try:
        os.close(os.open(probe, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600))
        os.unlink(probe)
    except OSError as error:
        raise failure(error, folder) from error


def sweep(folder: str | os.PathLike[str], *patterns: str) -> list[Path]:
    """Remove the temporaries of dead writers of these file names or sequence patterns; return what was removed.

    A writer on this host is dead if its lock is free; one on another host if its temporary is older than a day.
    """
    sequences = [Sequence(os.path.basename(pattern)) for pattern in patterns]
    with _folder_lock(Path(folder)):
        return _sweep(Path(folder), lambda name: any(sequence.frame_of(name) is not None for sequence in sequences))


def _sweep(folder: Path, is_ours: Callable[[str], bool]) -> list[Path]:
    """Remove the temporaries of dead writers in a folder, of final names for which ``is_ours`` returns True."""
    removed = []
    for path, name, host, pid in _claims_in(folder):
        if is_ours(name) and not _lives(path, host, pid):
            with suppress(OSError):
                path.unlink()
                removed.append(path)
    return removed


def _take(final: Path) -> tuple[Path, int]:
    """Make and lock our temporary; return its path and file descriptor.

    Raises ClaimedError where a living writer has a claim, OSError where the folder cannot be written.
    """
    temporary = final.parent / f".{final.name}.{HOST}.{os.getpid()}.tmp"
    with _folder_lock(final.parent):
        _sweep(final.parent, lambda name: name == final.name)
        others = _others(final, temporary)
        if others:
            raise _claimed(final, *others[0])
        try:
            fd = os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_RDWR | getattr(os, "O_BINARY", 0), 0o666)
        except FileExistsError:  # another thread of this process
            raise _claimed(final, HOST, os.getpid()) from None
        if fcntl is not None:
            with suppress(OSError):  # a file system without locks: the process id and the age must do
                fcntl.flock(fd, fcntl.LOCK_EX)
        # Where the folder could not be locked somebody may have come in between: then both see the other, and stop.
        others = _others(final, temporary)
    if others:
        os.unlink(temporary)
        os.close(fd)
        raise _claimed(final, *others[0])
    return temporary, fd


def _claimed(final: Path, host: str, pid: int) -> ClaimedError:
    """Return the error that names who is writing the frame."""
    return ClaimedError(f"being written by {host}:{pid}", file=str(final))


def _others(final: Path, own: Path) -> list[tuple[str, int]]:
    """Return who else, (host, pid), has a claim on ``final``. Claims of the dead have been swept before."""
    return [(host, pid) for path, name, host, pid in _claims_in(final.parent) if name == final.name and path != own]


def _claims_in(folder: Path) -> Iterator[tuple[Path, str, str, int]]:
    """Yield every claim in a folder: temporary, final name, host, pid. None for a folder that cannot be listed."""
    try:
        names = os.listdir(folder)
    except OSError:
        return
    for entry in names:
        match = _CLAIM.fullmatch(entry)
        if match:
            yield folder / entry, match["name"], match["host"], int(match["pid"])


def _lives(path: Path, host: str, pid: int) -> bool:
    """Return True while the writer of a temporary may still be at work."""
    try:
        age = time.time() - path.stat().st_mtime
    except OSError:
        return False  # gone already
    if host == HOST and fcntl is not None:
        try:
            fd = os.open(path, os.O_RDWR)
        except FileNotFoundError:
            return False
        except OSError:
            return _process_lives(pid)
        try:
            fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
        except OSError:  # a file system without locks
            return _process_lives(pid)
        finally:
            os.close(fd)
        return False
    return age < STALE_AFTER


def _process_lives(pid: int) -> bool:
    """Return True unless this host surely has no such process."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True
    return True


@contextmanager
def _folder_lock(folder: Path) -> Iterator[None]:
    """Lock a folder, where that can be done: one process of this host at a time looks for claims and makes its own."""
    if fcntl is None:
        yield
        return
    try:
        fd = os.open(folder, os.O_RDONLY)
    except OSError:  # a folder that may be written but not listed
        yield
        return
    try:
        with suppress(OSError):
            fcntl.flock(fd, fcntl.LOCK_EX)
        yield
    finally:
        os.close(fd)


def _sync_folder(folder: Path) -> None:
    """Write a folder's entries to disk, where the system can: a rename then lasts through a power cut."""
    with suppress(OSError):
        fd = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(fd)
        finally:
            os.close(fd)
