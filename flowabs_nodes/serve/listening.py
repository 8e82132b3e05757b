"""Sockets that clients connect to: one in a folder of this user alone, or one of this machine alone; and the token."""

from __future__ import annotations

import os
import secrets
import socket
import stat
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from flowabs_nodes import signals
from flowabs_nodes.errors import CommandError

TOKEN = "FLOWABS_TOKEN"
_LEAST_TOKEN = 16  # letters

_BACKLOG = 64


def token() -> str:
    """Return what clients have to say: ``$FLOWABS_TOKEN``, or a new secret. Raises CommandError for one too short."""
    given = os.environ.get(TOKEN, "")
    if given and len(given) < _LEAST_TOKEN:
        raise CommandError(
            f"${TOKEN}: expected at least {_LEAST_TOKEN} letters, found {len(given)}",
            code="bad-value",
            hint="unset it, and the server makes one",
        )
    return given or secrets.token_urlsafe(32)


@contextmanager
def listening_port(port: int) -> Iterator[tuple[socket.socket, str]]:
    """Listen on a port of 127.0.0.1, 0 for any that is free; give the socket and its address.

    Raises CommandError where that cannot be.
    """
    listener = socket.socket(socket.AF_INET)
    with listener:
        if sys.platform == "win32":  # where REUSEADDR would let others take the port away
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_EXCLUSIVEADDRUSE, 1)
        else:
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind(("127.0.0.1", port))
            listener.listen(_BACKLOG)
        except OSError as error:
            raise CommandError(f"cannot listen on port {port}: {error.strerror}", code="bad-address") from None
        yield listener, f"127.0.0.1:{listener.getsockname()[1]}"


@contextmanager
def listening_socket(path: Path) -> Iterator[tuple[socket.socket, str]]:
    """Listen on a Unix socket; give it and its absolute path, which is removed at the end.

    A socket that a server left which was killed is taken away first.

    Raises
    ------
    CommandError
        The folder is not this user's alone, another server is there, or something else is; or not on this system.
    """
    if not hasattr(socket, "AF_UNIX") or sys.platform == "win32":
        raise CommandError("--socket is not for this system", code="bad-address", hint="--port 0 is")
    path = path.absolute()
    _check_folder(path.parent)
    _take_away_dead(path)
    with socket.socket(socket.AF_UNIX) as listener:
        before = os.umask(0o177)
        try:
            listener.bind(os.fspath(path))
        except OSError as error:
            raise CommandError(
                f"cannot listen: {error.strerror or error}", code="bad-address", file=os.fspath(path)
            ) from None
        finally:
            os.umask(before)
        remove = _remover(path)
        signals.before_the_end.append(remove)
        try:
            listener.listen(_BACKLOG)
            yield listener, os.fspath(path)
        finally:
            remove()
            signals.before_the_end.remove(remove)


def _check_folder(folder: Path) -> None:
    """Raise CommandError unless a folder is this user's, and nobody else's to look into."""
    try:
        found = folder.stat()
    except OSError as error:
        raise CommandError(
            f"cannot listen: {error.strerror}",
            code="bad-address",
            hint=f"mkdir -m 700 {folder}",
            file=os.fspath(folder),
        ) from None
    if found.st_uid != os.geteuid() or found.st_mode & 0o077:
        raise CommandError(
            f"expected a folder of this user alone, 0700, found {found.st_mode & 0o777:04o}",
            code="bad-address",
            hint="mkdir -m 700 makes one",
            file=os.fspath(folder),
        )


def _take_away_dead(path: Path) -> None:
    """Remove a socket that nobody listens on; raise CommandError where somebody does, or where it is no socket."""
    try:
        mode = path.lstat().st_mode
    except OSError:
        return
    if not stat.S_ISSOCK(mode):
        raise CommandError("expected a new name, or a server's socket", code="bad-address", file=os.fspath(path))
    with socket.socket(socket.AF_UNIX) as probe:
        try:
            probe.connect(os.fspath(path))
        except ConnectionRefusedError:
            path.unlink(missing_ok=True)
            return
        except OSError:
            return  # bind tells what is wrong
    raise CommandError("another server listens here", code="bad-address", file=os.fspath(path))


def _remover(path: Path) -> Callable[[], None]:
    """Return a function that removes the socket at ``path``, if it is still the one that is there now."""
    ours = path.lstat()

    def remove() -> None:
        with suppress(OSError):
            found = path.lstat()
            if (found.st_ino, found.st_dev) == (ours.st_ino, ours.st_dev):
                path.unlink()

    return remove
