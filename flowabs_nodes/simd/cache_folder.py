"""The folders that compiled kernels are kept in: where they are, and who else could have put something there.

A kernel read from disk is code that runs. So a folder counts only if it belongs to the user or to root, and nobody else
can write to it, nor to the folder that was named for it (``/tmp``, where all may write but only to their own, is good
enough); above these, no folder may be open to everybody. Windows has no such owners, and nothing is checked there.
"""

from __future__ import annotations

import logging
import os
import shutil
import stat
import sys
import uuid
from functools import cache
from pathlib import Path
from typing import NamedTuple

from numba import config

from flowabs_nodes.simd.kernel_version import VERSION

KEPT = 4  # folders of other versions that stay beside the one in use, the latest used

log = logging.getLogger("flowabs")
_left_alone: set[Path] = set()  # folders that are damaged and could not be moved away


class Place(NamedTuple):
    """A kernel folder, and the folder above it that somebody named: a setting, or a convention."""

    named: Path
    folder: Path


def places() -> list[Place]:
    """Return where kernels of this version are looked for, in order: the environment's choice, or package and user."""
    if not VERSION:
        return []
    name = f"kernels-{VERSION}"
    if config.CACHE_DIR:
        named = Path(config.CACHE_DIR).absolute()
        return [Place(named, named / "flowabs" / name)]
    package, user = Path(__file__).absolute().parents[1] / "__pycache__", user_folder() / "flowabs"
    return [Place(named, named / name) for named in (package, user) if named.is_absolute()]


def user_folder() -> Path:
    """Return where programs of the user keep what they can make again; relative where the user has no home."""
    home = Path(os.path.expanduser("~"))
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local")
    if sys.platform == "darwin":
        return home / "Library" / "Caches"
    given = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return given if given.is_absolute() else home / ".cache"


def is_ours(status: os.stat_result) -> bool:
    """Return whether a file or folder belongs to the user or root, and nobody else can write to it."""
    return os.name == "nt" or (status.st_uid in (0, os.geteuid()) and not status.st_mode & 0o022)


def objection(place: Place) -> str:
    """Return why a folder does not count, or "": of what does not exist yet, only what is above it is looked at."""
    if place.folder in _left_alone:
        return f"{place.folder} is damaged"
    if os.name == "nt":
        return ""
    own, last = place.folder.resolve(), place.named.resolve()
    named = False  # above the folder that was named
    for folder in (own, *own.parents):
        try:
            status = folder.stat()
        except FileNotFoundError:
            continue
        except OSError as problem:
            return str(problem)
        shared = status.st_mode & (stat.S_IWOTH if named else stat.S_IWOTH | stat.S_IWGRP)
        if not named and status.st_uid not in (0, os.geteuid()):
            return f"{folder} belongs to another user"
        if shared and (folder == own or not status.st_mode & stat.S_ISVTX):
            return f"others can write to {folder}"
        named = named or folder == last
    return ""


def readable() -> list[Path]:
    """Return the folders that exist and count, in order."""
    return [place.folder for place in places() if place.folder.is_dir() and not objection(place)]


def writable(suffix: str = "") -> Path | None:
    """Return the first folder that counts and takes files, made if need be; None where there is none, said once.

    With a suffix it is another folder beside these, which only the user may enter.
    """
    problems = []
    for named, folder in places():
        place = Place(named, folder.with_name(f"{folder.name}-{suffix}") if suffix else folder)
        try:
            problem = objection(place)
            if not problem:
                _make(place.folder, 0o700 if suffix else 0o755)
                problem = objection(place) or (
                    "" if os.access(place.folder, os.W_OK) else f"{place.folder} is read-only"
                )
        except OSError as error:
            problem = str(error)
        if not problem:
            return place.folder
        problems.append(problem)
    warn("; ".join(problems) or "the package has no sources to know them by")
    return None


@cache
def warn(problem: str) -> None:
    """Say once that each process compiles its kernels for itself, in memory."""
    log.warning("compiled kernels cannot be kept, each process compiles them again: %s", problem)


def set_aside(folder: Path, problem: BaseException) -> None:
    """Move a folder away from which a kernel could not be loaded: nothing in it is trusted any more."""
    aside = folder.with_name(f"{folder.name}-damaged-{uuid.uuid4().hex[:8]}")
    try:
        folder.rename(aside)
    except FileNotFoundError:  # another process was first
        return
    except OSError:
        _left_alone.add(folder)
        aside = folder
    log.warning(
        "a compiled kernel could not be loaded (%s: %s); all are compiled afresh, the old ones are in %s",
        type(problem).__name__,
        problem,
        aside,
    )


def _make(folder: Path, mode: int) -> None:
    """Make a folder, and those above it, for the user alone to write to; remove former versions beside it."""
    if folder.exists():
        return
    for each in reversed((folder, *folder.parents)):
        if not each.exists():
            each.mkdir(mode if each == folder else 0o755, exist_ok=True)
    _sweep(folder)


def _sweep(new: Path) -> None:
    """Remove folders of former versions, but for the latest."""
    others = [folder for folder in new.parent.glob("kernels-*") if folder != new]
    others.sort(key=_last_changed)
    for old in others[:-KEPT]:
        shutil.rmtree(old, ignore_errors=True)


def _last_changed(folder: Path) -> float:
    try:
        return folder.stat().st_mtime
    except OSError:  # another process has removed it
        return 0.0
