"""The command that makes just some frames of a run again, as a shell takes it."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
from collections.abc import Sequence

_NOT_FOR_A_LINE = re.compile("[\x00-\x1f\x7f\ud800-\udfff]")


def command_for(arguments: Sequence[str], frames: str) -> str:
    """Return the command ``flowabs run`` with the ``arguments``, but for ``frames``, a range."""
    kept: list[str] = []
    rest = iter(arguments)
    for argument in rest:
        if argument == "--frames":
            next(rest, None)
        elif not argument.startswith("--frames="):
            kept.append(argument)
    return command([*kept, "--frames", frames])


def command(arguments: Sequence[str]) -> str:
    """Return ``flowabs run`` with the ``arguments``, on one line as a shell takes it."""
    words = ["flowabs", "run", *arguments]
    return subprocess.list2cmdline(words) if os.name == "nt" else " ".join(map(_quoted, words))


def _quoted(word: str) -> str:
    """Return a word as a shell takes it, on one line of text: bytes and control characters as bash's $'...'."""
    if not _NOT_FOR_A_LINE.search(word):
        return shlex.quote(word)
    letters = []
    for letter in word:
        if letter in "'\\":
            letters.append("\\" + letter)
        elif _NOT_FOR_A_LINE.match(letter):
            letters.extend(f"\\x{byte:02x}" for byte in os.fsencode(letter))
        else:
            letters.append(letter)
    return f"$'{''.join(letters)}'"
