"""Shows how a run goes: a bar on a terminal, a line a frame in a log, one event a line for programs."""

from __future__ import annotations

import json
import sys
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import click

from flowabs_nodes.errors import FlowabsError

if TYPE_CHECKING:
    from tqdm import tqdm

    from flowabs_nodes.engine.report import Report

Event = dict[str, Any]


def on_a_terminal() -> bool:
    """Return True where stdout and stderr both go to a terminal; if one is a log, that log still gets its lines."""
    return sys.stdout.isatty() and sys.stderr.isatty()


class Lines:
    """Show a line a frame on stdout, after the notes on this frame; failures and warnings go to stderr."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: type[BaseException] | BaseException | TracebackType | None) -> None:
        pass

    def event(self, event: Event) -> None:
        """Show an event of the engine."""
        match event["event"]:
            case "note":
                self.line(_note_text(event), error=event["level"] == "warning")
            case "frame":
                self.frame(event)

    def frame(self, event: Event) -> None:
        """Show a frame that has ended."""
        if event["status"] == "failed":
            frame = f"frame {event['frame']}"
            message = event["message"].replace(f"{frame}: ", "", 1)  # said once is enough
            self.line(f"{frame}  failed  {message}", error=True)
        else:
            files = ", ".join(event["files"])
            self.line(f"frame {event['frame']}  {event['status']:7} {event['seconds']:7.2f} s  {files}".rstrip())

    def line(self, text: str, *, error: bool = False) -> None:
        """Print one line."""
        click.echo(text, err=error)

    def error(self, error: FlowabsError) -> None:
        """Show nothing here of a run that could not begin: the caller tells the error."""

    def end(self, report: Report) -> None:
        """Show the summary of a run that has ended, and its profile."""
        counts = ", ".join(f"{count} {status}" for status, count in report.counts.items() if count)
        stopped = {130: "stopped: ", 143: "stopped: "}.get(report.exit_code, "")
        self.line(f"{stopped}{counts or 'nothing done'} in {report.seconds:.2f} s", error=bool(stopped))
        for row in _profile_lines(report):
            self.line(row)


class Bar(Lines):
    """Show a bar with frames/s and the time left; notes and failures stand above it."""

    def __init__(self) -> None:
        self.bar: tqdm[Any] | None = None

    def __exit__(self, *exception: type[BaseException] | BaseException | TracebackType | None) -> None:
        if self.bar is not None:
            self.bar.close()

    def event(self, event: Event) -> None:
        """Show an event of the engine."""
        if event["event"] == "start":
            from tqdm import tqdm

            self.bar = tqdm(total=event["frames"], unit=" frames", desc=event["graph"] or None, dynamic_ncols=True)
        super().event(event)

    def frame(self, event: Event) -> None:
        """Move the bar on for a frame that has ended, and say why where it failed."""
        if event["status"] == "failed":
            super().frame(event)
        if self.bar is not None:
            self.bar.update()

    def line(self, text: str, *, error: bool = False) -> None:
        """Print one line above the bar."""
        from tqdm import tqdm

        tqdm.write(text, file=sys.stderr if error else sys.stdout)

    def end(self, report: Report) -> None:
        """Leave the bar as it is, and show the summary below it."""
        if self.bar is not None:
            self.bar.close()
        super().end(report)


class JsonLines(Lines):
    """Print each event as a line of JSON on stdout; failures are also told to people, on stderr."""

    def event(self, event: Event) -> None:
        """Print an event of the engine."""
        click.echo(json.dumps(event))
        if event["event"] == "frame" and event["status"] == "failed":
            self.frame(event)

    def error(self, error: FlowabsError) -> None:
        """Print the error of a run that could not begin."""
        click.echo(json.dumps({"event": "error", "error": error.to_dict()}))

    def end(self, report: Report) -> None:
        """Print the profile, if there is one; the run's last event has said the rest."""
        if report.profile is not None:
            rows = [
                {"node": each.node, "type": each.type, "frames": each.frames, "seconds": round(each.seconds, 4)}
                for each in report.profile
            ]
            click.echo(json.dumps({"event": "profile", "nodes": rows}))


def _note_text(event: Event) -> str:
    """Return the line for a note."""
    frame = "" if event["frame"] is None else f"frame {event['frame']}  "
    level = "warning: " if event["level"] == "warning" else ""
    node = f"{event['node']}: " if event["node"] else ""
    return f"{frame}{level}{node}{event['text']}"


def _profile_lines(report: Report) -> list[str]:
    """Return the lines of a table: seconds by node, the slowest first, and each node's share."""
    if not report.profile:
        return []
    total = sum(each.seconds for each in report.profile) or 1.0
    width = max(len("node"), *(len(each.node) for each in report.profile))
    kinds = max(len("type"), *(len(each.type) for each in report.profile))
    head = f"{'node':{width}}  {'type':{kinds}}  seconds   share  a frame  longest"
    rows = (
        f"{each.node:{width}}  {each.type:{kinds}}  {each.seconds:7.3f}  {each.seconds / total:6.1%}"
        f"  {each.seconds / each.frames:7.3f}  {each.longest:7.3f}"
        for each in report.profile
    )
    return ["", head, *rows]
