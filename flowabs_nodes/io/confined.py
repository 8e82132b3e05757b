"""Hold on to what was looked at: a file or folder within a run's root, whatever is renamed or linked in meanwhile.

To look at a path and to open it are two steps, and somebody may put a link in between. So the file is opened first,
without a look into it, and the system is asked where it is; all further work goes through what is open. Linux tells
that, and can open it again, by ``/proc/self/fd``; elsewhere a path is only looked at before it is opened.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from flowabs_nodes.io.settings import outside_root

_OPEN = "/proc/self/fd"
#: Whether what is open has a name here by which it can be opened again.
HOLDS = hasattr(os, "O_PATH") and os.path.isdir(_OPEN)


@contextmanager
def held_file(path: str | os.PathLike[str], root: Path | None) -> Iterator[str]:
    """Give a path that leads to the file that ``path`` leads to now, until the end; the same one without ``root``.

    Raises
    ------
    CommandError
        outside-root, where the file is not within ``root``.
    OSError
        There is no such file, or it may not be opened.
    """
    name = os.fspath(path)
    if root is None or not HOLDS:
        yield name
        return
    fd = os.open(name, os.O_PATH | os.O_CLOEXEC)
    try:
        yield check_open(fd, name, root)
    finally:
        os.close(fd)


@contextmanager
def held_folder(folder: Path, root: Path | None) -> Iterator[Path]:
    """Make a folder, and give a path that leads to it, until the end, wherever its name leads by then.

    Folders above it that are not there are made one in the other, within ``root``. Without ``root`` the path is the
    folder's own. Raises as :func:`held_file` does.
    """
    if root is None or not HOLDS:
        folder.mkdir(parents=True, exist_ok=True)
        yield folder
        return
    missing: list[str] = []
    place = folder
    while not place.exists() and place != place.parent:
        missing.append(place.name)
        place = place.parent
    fd = os.open(place, os.O_PATH | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        held = check_open(fd, os.fspath(folder), root)
        for name in reversed(missing):
            fd = _inner(fd, name)
            held = check_open(fd, os.fspath(folder), root)
        yield Path(held)
    finally:
        os.close(fd)


def _inner(outer: int, name: str) -> int:
    """Return the folder of this name in an open one, made if need be, and close the outer one; no link is followed."""
    with suppress(FileExistsError):  # another run was faster
        os.mkdir(name, dir_fd=outer)
    inner = os.open(name, os.O_PATH | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC, dir_fd=outer)
    os.close(outer)
    return inner


def check_open(fd: int, name: str, root: Path) -> str:
    """Return a path that leads to what is open, called ``name``. Raises CommandError where it is not within ``root``.

    Only where :data:`HOLDS`.
    """
    held = f"{_OPEN}/{fd}"
    if not Path(os.readlink(held)).is_relative_to(os.path.realpath(root)):
        raise outside_root(name, root)
    return held
