"""Shows a run in several ways at once: on the screen, and in a log."""

from __future__ import annotations

from contextlib import ExitStack
from types import TracebackType
from typing import TYPE_CHECKING, Self

from flowabs_nodes.cli.progress import Event, Lines

if TYPE_CHECKING:
    from flowabs_nodes.engine.report import Report
    from flowabs_nodes.errors import FlowabsError


class Views:
    """Hands each event of a run to every view, in order."""

    def __init__(self, *views: Lines) -> None:
        self._views = views
        self._open = ExitStack()

    def __enter__(self) -> Self:
        for view in self._views:
            self._open.enter_context(view)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._open.__exit__(kind, error, trace)

    def event(self, event: Event) -> None:
        """Show an event of the engine."""
        for view in self._views:
            view.event(event)

    def error(self, error: FlowabsError) -> None:
        """Show why a run could not begin."""
        for view in self._views:
            view.error(error)

    def end(self, report: Report) -> None:
        """Show the summary of a run that has ended."""
        for view in self._views:
            view.end(report)
