"""Writes every line of a run to a file too, each with the time (``--log-file``)."""

from __future__ import annotations

import os
import stat
import sys
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, TextIO

import flowabs_nodes
from flowabs_nodes.cli.progress import Again, Lines, Loudness
from flowabs_nodes.cli.rerun import command
from flowabs_nodes.cli.streams import one_line
from flowabs_nodes.errors import CommandError

if TYPE_CHECKING:
    from flowabs_nodes.errors import FlowabsError


def open_log(path: str, *, graph: str, root: Path | None) -> TextIO:
    """Open a log to append to, line by line; a folder that is not there is made.

    Raises
    ------
    CommandError
        The file cannot be written, lies outside ``root``, or is no log: a picture by its name, the graph, or something
        that would have to be read by another program at the same time.
    """
    from flowabs_nodes.io import confined, formats
    from flowabs_nodes.io.settings import Settings, checked

    name = checked(path, Settings(root=root))

    def refuse(why: str, hint: str = "") -> CommandError:
        return CommandError(f"--log-file: {why}", code="bad-log-file", file=str(name), hint=hint)

    if formats.by_extension(str(name)) is not None:
        raise refuse("this is the name of a picture", "a log is a text, such as run.log")
    try:
        with confined.held_folder(name.parent, root) as folder:
            place = folder / name.name
            if place.exists():
                if os.path.exists(graph) and place.samefile(graph):
                    raise refuse("this is the graph")
                if not (stat.S_ISREG(mode := place.stat().st_mode) or stat.S_ISCHR(mode)):
                    raise refuse("this is no file to append to")

            def opener(path: str, flags: int) -> int:
                fd = os.open(place, flags, 0o666)
                if root is not None and confined.HOLDS:
                    confined.check_open(fd, path, root)  # it may be a link by now
                return fd

            return open(name, "a", buffering=1, encoding="utf-8", errors="backslashreplace", opener=opener)
    except OSError as error:
        raise refuse(f"cannot be written: {error.strerror or error}") from error


class LogFile(Lines):
    """Writes the lines of a run to an open log, which is closed at the end: all of them, also where -q shows few.

    A log that cannot be written any more is told once on stderr, and stops no frame.
    """

    def __init__(self, log: TextIO, loudness: Loudness, again: Again, arguments: Sequence[str]) -> None:
        super().__init__(max(loudness, Loudness.NORMAL), again)
        self._log: TextIO | None = log
        self._name = log.name
        self.line(f"flowabs {flowabs_nodes.__version__}: {command(arguments)}")

    def __exit__(self, *exception: type[BaseException] | BaseException | TracebackType | None) -> None:
        error = exception[1]
        if isinstance(error, Exception):
            for text in f"flowabs: {error}".splitlines():
                self.line(text)
        elif error is not None:
            self.line("stopped")
        if self._log is not None:
            self._try(self._log.close)

    def line(self, text: str, *, error: bool = False) -> None:
        """Append one line, after the time."""
        if self._log is not None:
            now = datetime.now().astimezone().isoformat(sep=" ", timespec="seconds")
            self._try(self._log.write, f"{now} {one_line(text)}\n")

    def error(self, error: FlowabsError) -> None:
        """Append nothing: leaving with the error says it."""

    def _try(self, action: Any, *arguments: str) -> None:
        try:
            action(*arguments)
        except (OSError, ValueError) as error:
            self._log = None
            why = getattr(error, "strerror", None) or error
            print(f"flowabs: warning: {one_line(self._name)} cannot be written: {why}", file=sys.stderr, flush=True)
