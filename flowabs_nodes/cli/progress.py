"""Shows how a run goes: a line a frame in a log, one event a line for programs. The bar of a terminal is ``bar.py``."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from enum import IntEnum
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from flowabs_nodes.cli.streams import one_line
from flowabs_nodes.cli.summary import failed_lines, profile_lines

if TYPE_CHECKING:
    from flowabs_nodes.engine.report import Report
    from flowabs_nodes.errors import FlowabsError

Event = dict[str, Any]

#: Returns the command that makes just some frames again; their range is given.
Again = Callable[[str], str]


class Loudness(IntEnum):
    """How much is said: warnings and failures; frames and notes too (normal); nodes and details too."""

    QUIET = 0
    NORMAL = 1
    VERBOSE = 2


def on_a_terminal() -> bool:
    """Return True where stdout and stderr both go to a terminal; if one is a log, that log still gets its lines."""
    return sys.stdout.isatty() and sys.stderr.isatty()


class Lines:
    """Show a line a frame on stdout, after the notes on this frame; failures and warnings go to stderr.

    Each event that is worth a line becomes one (:meth:`event`); who shows lines elsewhere overrides :meth:`line`.
    """

    def __init__(self, loudness: Loudness, again: Again) -> None:
        self.loudness = loudness
        self._again = again
        self._asked = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: type[BaseException] | BaseException | TracebackType | None) -> None:
        pass

    def event(self, event: Event) -> None:
        """Show an event of the engine."""
        loud, verbose = self.loudness > Loudness.QUIET, self.loudness == Loudness.VERBOSE
        match event["event"]:
            case "start":
                self._asked = event["frames"]
            case "note" | "shared-note":
                warning = event["level"] == "warning"
                if warning or (loud if event["event"] == "note" else verbose):  # shared notes were said before
                    self.line(_note_text(event), error=warning)
            case "detail" if verbose:
                self.line(_note_text(event))
            case "node" if verbose and event["status"] == "done":
                type = f"{event['type']} " if event["type"] else ""
                self.line(f"frame {event['frame']}  {event['node']}: {type}{event['seconds']:.2f} s")
            case "frame":
                self.frame(event)
            case "profile" if verbose:
                self._table(event["nodes"])

    def frame(self, event: Event) -> None:
        """Show a frame that has ended."""
        if event["status"] == "failed":
            frame = f"frame {event['frame']}"
            message = event["message"].replace(f"{frame}: ", "", 1)  # said once is enough
            self.line(f"{frame}  failed  {message}", error=True)
        elif self.loudness > Loudness.QUIET:
            files = ", ".join(event["files"])
            self.line(f"frame {event['frame']}  {event['status']:7} {event['seconds']:7.2f} s  {files}".rstrip())

    def line(self, text: str, *, error: bool = False) -> None:
        """Print one line."""
        print(one_line(text), file=sys.stderr if error else sys.stdout, flush=True)

    def error(self, error: FlowabsError) -> None:
        """Show nothing here of a run that could not begin: the caller tells the error."""

    def end(self, report: Report) -> None:
        """Show the summary of a run that has ended: counts, profile, and what has to be made again."""
        counts = ", ".join(f"{count} {status}" for status, count in report.counts.items() if count)
        stopped = {130: "stopped: ", 143: "stopped: "}.get(report.exit_code, "")
        left = f", {len(report.not_made)} not made" if report.not_made else ""
        if self.loudness > Loudness.QUIET or stopped:
            self.line(f"{stopped}{counts or 'nothing done'}{left} in {report.seconds:.2f} s", error=bool(stopped))
        if report.profile:
            from flowabs_nodes.engine.report import profile_event

            self._table(profile_event(report.profile)["nodes"])
        self.failed(report)

    def failed(self, report: Report) -> None:
        """Show which frames failed and why, and the command that makes these again; nothing of a run of one frame."""
        if self._asked > 1:
            for text in failed_lines(report, self._again):
                self.line(text, error=True)

    def _table(self, nodes: list[dict[str, Any]]) -> None:
        for row in profile_lines(nodes):
            self.line(row)


class JsonLines(Lines):
    """Print each event as a line of JSON on stdout; failures are also told to people, on stderr.

    Quiet leaves out nodes and notes, but for warnings; details are there only if verbose.
    """

    def event(self, event: Event) -> None:
        """Print an event of the engine."""
        kind = event["event"]
        note = kind in ("note", "shared-note") and event["level"] != "warning"
        if kind == "start":
            self._asked = event["frames"]
        if self.loudness == Loudness.QUIET and (note or kind == "node"):
            return
        if self.loudness == Loudness.VERBOSE or kind != "detail":
            self._print(event)
        if kind == "frame" and event["status"] == "failed":
            self.frame(event)

    def error(self, error: FlowabsError) -> None:
        """Print the error of a run that could not begin."""
        self._print({"event": "error", "error": error.to_dict()})

    def end(self, report: Report) -> None:
        """Print the profile, if there is one; the run's last event has said the rest. People are told what failed."""
        if report.profile is not None:
            from flowabs_nodes.engine.report import profile_event

            self._print(profile_event(report.profile))
        self.failed(report)

    def _print(self, event: Event) -> None:
        print(json.dumps(event), flush=True)


def _note_text(event: Event) -> str:
    """Return the line for a note of one frame, of many, or of none."""
    if event["event"] == "shared-note":
        where = f"frames {event['frames']}: "
    else:
        where = "" if event["frame"] is None else f"frame {event['frame']}  "
    level = "warning: " if event.get("level") == "warning" else ""
    node = f"{event['node']}: " if event["node"] else ""
    return f"{where}{level}{node}{event['text']}"
