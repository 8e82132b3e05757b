"""Name and open the two files of a claim on a frame ``x.exr``, and read what somebody else's say.

``.x.exr.claim`` exists while somebody writes the frame: making it is what decides between two who want to, on every
file system, and it is found without listing the folder. It says who writes. ``.x.exr.{host}.{token}.tmp`` is where
the bytes go; its name is never used again, so that a writer that comes back from the dead publishes nobody else's.
"""

from __future__ import annotations

import hashlib
import os
import re
import secrets
import socket
import stat
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from flowabs_nodes.io import file_lock
from flowabs_nodes.io.file_lock import NOWHERE

#: This host, as claims name it. It is for people: two hosts may have one name.
HOST = re.sub(r"[^A-Za-z0-9_-]", "-", socket.gethostname())[:32] or "localhost"

#: The most bytes of a file name.
_LONGEST = 255
#: A token is 8 digits for the reach of its lock and 10 random ones; version 0.2.0 had the process id there.
_TEMPORARY = re.compile(
    r"\.(?P<name>.+)\.(?P<host>[A-Za-z0-9_-]+)\.(?P<token>[0-9a-f]{8,40}|[0-9]{1,10})\.tmp", re.DOTALL
)
_CLAIM = re.compile(r"\.(?P<name>.+)\.claim", re.DOTALL)
_BURIAL = re.compile(r"\.(?P<name>.+)\.[0-9a-f]+\.burial", re.DOTALL)
_CONTENT = re.compile(r"([A-Za-z0-9_-]{1,64}) ([0-9a-f]{18}) (\d{1,20})\n")


class Writer(NamedTuple):
    """Who has a claim, as its file says: ``token`` names the claim, ``host`` and ``pid`` are for people."""

    host: str
    token: str
    pid: int

    @property
    def reach(self) -> str:
        """Return who sees the claim's lock (:func:`flowabs_nodes.io.file_lock.reach`)."""
        return self.token[:8] if len(self.token) == 18 else NOWHERE

    def __str__(self) -> str:
        return f"{self.host} (process {self.pid})" if self.pid else self.host


#: A claim that does not say, or not yet, whose it is.
UNKNOWN = Writer("another run", "", 0)


class Found(NamedTuple):
    """A claim's file as it was seen: who it names, and what changes when it is touched or replaced."""

    writer: Writer
    signature: tuple[int, int, int]


def new_writer(reach: str) -> Writer:
    """Return this process under a new token."""
    return Writer(HOST, reach + secrets.token_hex(5), os.getpid())


def claim_path(final: Path) -> Path:
    """Return the file that exists while somebody writes ``final``."""
    return final.parent / f".{stem(final.name)}.claim"


def temporary_path(final: Path, writer: Writer) -> Path:
    """Return the file that a writer's bytes go to."""
    return final.parent / f".{stem(final.name)}.{writer.host}.{writer.token}.tmp"


def burial_path(final: Path, found: Found) -> Path:
    """Return the file by which one of several claims the right to remove a dead claim, and no other one."""
    return final.parent / f".{stem(final.name)}.{found.writer.token or f'{found.signature[0]:x}'}.burial"


def stem(name: str) -> str:
    """Return a file's name, or where that is too long to add to it, its beginning and a hash of it."""
    limit = _LONGEST - len(f"..{'h' * 32}.{'t' * 18}.burial")
    data = os.fsencode(name)
    if len(data) <= limit:
        return name
    digest = hashlib.blake2b(data, digest_size=8).hexdigest()
    return f"{data[: limit - 17].decode('utf-8', 'ignore')}~{digest}"


def name_claimed(entry: str) -> str | None:
    """Return the stem of the final name that a claim's file belongs to; None for any other file."""
    for pattern in (_CLAIM, _TEMPORARY, _BURIAL):
        if match := pattern.fullmatch(entry):
            return match["name"]
    return None


def writer_named(entry: str) -> Writer | None:
    """Return the writer that a temporary's name tells; None for any other file."""
    match = _TEMPORARY.fullmatch(entry)
    if not match:
        return None
    old = len(match["token"]) <= 10 and match["token"].isdecimal()
    return Writer(match["host"], match["token"], int(match["token"]) if old else 0)


def is_burial(entry: str) -> bool:
    """Return True for the name of a :func:`burial_path`."""
    return _BURIAL.fullmatch(entry) is not None


def look(path: Path) -> Found | None:
    """Return what stands in a claim's file; None where there is no file of that name, or one that is no claim's.

    Of a temporary, whose content is a picture, nothing is read.
    """
    try:
        state = os.lstat(path)
    except OSError:
        return None
    if not stat.S_ISREG(state.st_mode):
        return None
    signature = (state.st_ino, state.st_mtime_ns, state.st_size)
    if named := writer_named(path.name):
        return Found(named, signature)
    text = b""
    fd = file_lock.open_regular(path)
    if fd is not None:
        try:
            text = os.read(fd, 200)
        except OSError:
            pass
        finally:
            os.close(fd)
    match = _CONTENT.fullmatch(text.decode("ascii", "replace"))
    return Found(Writer(match[1], match[2], int(match[3])) if match else UNKNOWN, signature)


class ClaimFile:
    """A file of a claim, made by this process: locked where locks are, and touched by the heartbeat.

    Raises FileExistsError where there is a file of that name.
    """

    def __init__(self, path: Path) -> None:
        flags = os.O_CREAT | os.O_EXCL | os.O_RDWR | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)
        self.path = path
        self._fd: int | None = os.open(path, flags, 0o666)
        self.locked = file_lock.lock(self._fd)

    @property
    def fd(self) -> int:
        """Return the open file. Raises OSError in a process that was forked off the one that has the claim."""
        if self._fd is None:
            raise OSError("the claim belongs to another process")
        return self._fd

    def write(self, data: bytes | memoryview) -> None:
        """Write every byte of ``data``. Raises OSError."""
        rest = memoryview(data)
        while rest:
            rest = rest[os.write(self.fd, rest) :]  # a write may be short

    def rename_new(self, path: Path) -> None:
        """Give the file another name, in one step where the file system has links.

        Raises FileExistsError where there is a file of that name, OSError.
        """
        try:
            if file_lock.fcntl is None:  # Windows, which removes no name of a file that is open
                raise NotImplementedError
            os.link(self.path, path)
        except FileExistsError:
            if os.fstat(self.fd).st_nlink < 2:  # it was not made, and its answer lost, on a network's file system
                raise
        except (OSError, NotImplementedError, AttributeError):  # no links here: somebody may see it half made
            made = ClaimFile(path)
            with open(self.path, "rb") as file:
                made.write(file.read())
            self.remove()
            self._fd, self.locked = made._fd, made.locked
        else:
            with suppress(OSError):
                os.unlink(self.path)
        self.path = path

    def touch(self) -> None:
        """Change the file's time, to the time of whoever keeps the file."""
        os.utime(self.fd if os.utime in os.supports_fd else self.path)

    def remove(self) -> None:
        """Remove the file, while it is still locked, and close it. In a forked copy of the process nothing happens."""
        if self._fd is None:
            return
        if file_lock.fcntl is None:  # Windows removes no file that is open
            self.close()
        with suppress(OSError):
            os.unlink(self.path)
        self.close()

    def close(self) -> None:
        """Unlock and close the file."""
        if self._fd is not None:
            fd, self._fd = self._fd, None
            file_lock.unlock(fd)
            os.close(fd)

    def abandon(self) -> None:
        """Close the file and leave it locked, by the process that this one is a copy of."""
        if self._fd is not None:
            fd, self._fd = self._fd, None
            with suppress(OSError):
                os.close(fd)
