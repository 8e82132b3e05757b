"""Shows a run in several ways at once: on the screen, and in a log."""

from __future__ import annotations

from contextlib import ExitStack
from types import TracebackType
from typing import TYPE_CHECKING, Self

from flowabs_nodes.cli.progress import Event, Lines

if TYPE_CHECKING:
    from flowabs_nodes.engine.report import Report
    from flowabs_nodes.errors import FlowabsError


class Shows:
    """Hands each event of a run to everything that shows it, in order."""

    def __init__(self, *shows: Lines) -> None:
        self._shows = shows
        self._open = ExitStack()

    def __enter__(self) -> Self:
        for show in self._shows:
            self._open.enter_context(show)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._open.__exit__(kind, error, trace)

    def event(self, event: Event) -> None:
        """Show an event of the engine."""
        for show in self._shows:
            show.event(event)

    def error(self, error: FlowabsError) -> None:
        """Show why a run could not begin."""
        for show in self._shows:
            show.error(error)

    def end(self, report: Report) -> None:
        """Show the summary of a run that has ended."""
        for show in self._shows:
            show.end(report)
