"""What reading and writing need to know about a run: the largest picture, the OCIO config, the folder it may touch."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path

from flowabs_nodes.errors import CommandError


@dataclass(frozen=True)
class Settings:
    """How pictures are read and written in one run.

    Parameters
    ----------
    max_pixels
        The most pixels that a frame may have; a larger one is refused before any memory is taken for it. The default,
        2**27, is 16384 x 8192.
    ocio
        An OCIO config (a path, or "ocio://..."); None: the pinned built-in one.
    root
        Nothing outside this folder is read or written, symbolic links included; None: no limit.
    """

    max_pixels: int = 2**27
    ocio: str | None = None
    root: Path | None = None


def checked(path: str | os.PathLike[str], settings: Settings) -> Path:
    """``path`` if it is a name that files have and lies within ``settings.root``; else CommandError.

    Where the last part of the name is a symbolic link it counts as where it leads.
    """
    name = os.fspath(path)
    if not name or "\0" in name:
        raise CommandError(f"{name!r} is not the name of a file", code="bad-path")
    if re.match(r"[A-Za-z][A-Za-z0-9+.-]+://", name):
        raise CommandError(f"{name!r} is an address, not a file", code="bad-path", hint="give a path on this machine")
    if settings.root is not None and not within(name, settings.root):
        raise CommandError(
            f"outside {os.fspath(settings.root)}, the folder this run may read and write",
            code="outside-root",
            file=name,
        )
    return Path(name)


def within(path: str | os.PathLike[str], root: str | os.PathLike[str]) -> bool:
    """True if ``path``, with every symbolic link followed, lies in the folder ``root``; it need not exist."""
    try:
        return Path(path).resolve().is_relative_to(Path(root).resolve())
    except (OSError, RuntimeError, ValueError):  # a loop of links; a name that no file can have
        return False


def same_file(a: str | os.PathLike[str], b: str | os.PathLike[str]) -> bool:
    """True if both names lead to one file, links of any kind included; neither need exist."""
    try:
        if Path(a).resolve() == Path(b).resolve():
            return True
        return os.path.samefile(a, b)
    except (OSError, RuntimeError, ValueError):
        return False
