"""Hold what reading and writing need to know about a run: size limit, OCIO config, the folder that it may touch."""

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
        An OCIO config (a path, or "ocio://..."). None: a run takes ``$OCIO`` (engine/ocio_choice.py) or else, as all
        functions of io do, the pinned built-in one.
    root
        Nothing outside this folder is read or written, symbolic links included; None: no limit.
    """

    max_pixels: int = 2**27
    ocio: str | None = None
    root: Path | None = None


def checked(path: str | os.PathLike[str], settings: Settings) -> Path:
    """Return ``path`` if a file can have that name and it lies within ``settings.root``. Raises CommandError.

    A symbolic link counts as the file that it leads to.
    """
    name = os.fspath(path)
    if not name or "\0" in name:
        raise CommandError(f"{name!r} is not the name of a file", code="bad-path")
    if re.match(r"[A-Za-z][A-Za-z0-9+.-]+://|file:", name):
        raise CommandError(f"{name!r} is an address, not a file", code="bad-path", hint="give a path on this machine")
    refuse_shell_words(name)
    if settings.root is not None and not within(name, settings.root):
        raise outside_root(name, settings.root)
    return Path(name)


def outside_root(name: str, root: Path) -> CommandError:
    """Return the error of a path that leads out of ``root``."""
    what = f"outside {os.fspath(root)}, the folder this run may read and write"
    return CommandError(what, code="outside-root", file=name)


#: What a shell expands, or another system understands, in the name of a file; each with what to write instead.
_SHELL_WORDS = (
    (re.compile(r"~[^/\\]*(?=[/\\])|~$"), "write the whole path, {home}: ~ is expanded by shells, outside of quotes"),
    (
        re.compile(r".*?(\$\{[^}]*\}|\$\([^)]*\)|`[^`]*`|\$(?!F\d*+(?![A-Za-z_]))[A-Za-z_]\w*)", re.DOTALL),
        "write the path itself: variables and commands are expanded by shells, outside of single quotes",
    ),
    (
        re.compile(r".*?(%[A-Za-z_][\w()]*%|![A-Za-z_]\w*!)", re.DOTALL),
        "write the path itself: variables are expanded by the command prompt",
    ),
    (
        re.compile(r".*?(\[(?:getenv|value|expression|python)\b[^\]]*\])", re.DOTALL),
        "write the path itself: expressions in brackets are Nuke's",
    ),
)
_WINDOWS_PATH = re.compile(r"[A-Za-z]:|\\\\|.*\\")


def refuse_shell_words(name: str) -> None:
    """Raise CommandError for a name with ``~``, ``$SHOT``, ``%SHOT%``, ``[getenv SHOT]``, or elsewhere a Windows path.

    It would only be found, or made, in a folder of that very name. A file that has the very name is no mistake.
    """
    if os.path.exists(name):
        return
    for pattern, hint in _SHELL_WORDS:
        if match := pattern.match(name):
            word = match[1] if match.re.groups else match[0]
            hint = hint.format(home=os.path.expanduser(name)) if "{home}" in hint else hint
            raise CommandError(f"{word} in a path is not expanded here", code="bad-path", file=name, hint=hint)
    if os.name != "nt" and _WINDOWS_PATH.match(name):
        hint = "write a path of this machine, with /"
        raise CommandError("a path of Windows, which this machine is not", code="bad-path", file=name, hint=hint)


def within(path: str | os.PathLike[str], root: str | os.PathLike[str]) -> bool:
    """Return True if ``path``, with every symbolic link followed, lies in the folder ``root``; it need not exist."""
    try:
        return Path(path).resolve().is_relative_to(Path(root).resolve())
    except (OSError, RuntimeError, ValueError):  # a loop of links; a name that no file can have
        return False
