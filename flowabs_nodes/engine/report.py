"""Reports what became of each frame and of the whole run, as objects and as plain events."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Literal

from flowabs_nodes.engine.profile import NodeTime
from flowabs_nodes.engine.stopwatch import Timing
from flowabs_nodes.errors import FlowabsError

Status = Literal["done", "skipped", "failed"]

#: A function that is called with each event of a run, a plain dict, in order: :func:`start_event`, those below it, and
#: those of :class:`~flowabs_nodes.engine.node_events.NodeEvents`. docs/running.md describes them.
Listener = Callable[[dict[str, Any]], None]

log = logging.getLogger("flowabs")


@dataclass(frozen=True, slots=True)
class Note:
    """Something to tell the person who runs the graph.

    ``once``: tell it only once per run, node and this word, though the text may differ. ``frame``: the frame that it is
    about, where that may be another one than the frame being rendered. ``detail``: only for who asks for more (-v).
    """

    text: str
    node: str = ""
    warning: bool = False
    once: str = ""
    frame: int | None = None
    detail: bool = False

    @property
    def level(self) -> str:
        """Return "warning" or "note"."""
        return "warning" if self.warning else "note"

    def __str__(self) -> str:
        return f"{self.node}: {self.text}" if self.node else self.text


@dataclass(frozen=True, slots=True)
class FrameReport:
    """One frame: "done" was written, "skipped" was there already or left out by ``missing``, "failed" has an error."""

    frame: int
    status: Status
    files: tuple[str, ...] = ()
    seconds: float = 0.0
    error: FlowabsError | None = None
    notes: tuple[Note, ...] = ()
    timings: tuple[Timing, ...] = ()

    def __repr__(self) -> str:
        what = self.error.message.partition("\n")[0] if self.error else ", ".join(self.files)
        return f"<FrameReport of frame {self.frame}: {self.status}, {self.seconds:.2f} s{': ' if what else ''}{what}>"


@dataclass(frozen=True, slots=True)
class Report:
    """A whole run. ``exit_code`` is what a process should exit with: 0, 1 for a failed frame, 130 or 143 if stopped.

    ``not_made`` are the frames that a stopped run has not made, failed ones aside.
    """

    frames: tuple[FrameReport, ...]
    exit_code: int
    seconds: float = 0.0
    notes: tuple[Note, ...] = ()
    profile: tuple[NodeTime, ...] | None = None
    not_made: tuple[int, ...] = ()

    def __repr__(self) -> str:
        counts = ", ".join(f"{count} {status}" for status, count in self.counts.items())
        frames = f"{len(self.frames)} frame{'' if len(self.frames) == 1 else 's'}"
        return f"<Report of {frames}: {counts}, exit code {self.exit_code}, {self.seconds:.2f} s>"

    @property
    def counts(self) -> dict[str, int]:
        """Return how many frames are done, skipped and failed."""
        counts = {"done": 0, "skipped": 0, "failed": 0}
        for frame in self.frames:
            counts[frame.status] += 1
        return counts


# ---------------------------------------------------------------------- events: one a line with --json


def start_event(graph: str, frames: int) -> dict[str, Any]:
    """Return the event of a run that begins: the graph's name, and how many frames there are to make."""
    return {"event": "start", "graph": graph, "frames": frames}


def note_event(note: Note, frame: int | None = None) -> dict[str, Any]:
    """Return the event of a note on a frame, or (frame None) on the graph; ``level`` is "note" or "warning".

    A note that knows its frame goes before ``frame``. What only those want to know who ask for more is "detail", an
    event of its own.
    """
    frame = frame if note.frame is None else note.frame
    if note.detail:
        return {"event": "detail", "frame": frame, "node": note.node or None, "text": note.text}
    return {"event": "note", "frame": frame, "node": note.node or None, "level": note.level, "text": note.text}


def tell_notes(notes: Iterable[Note], frame: int, on_event: Listener | None) -> None:
    """Tell a frame's notes to the listener, or write them to the logger "flowabs" where there is none."""
    for note in notes:
        if on_event is not None:
            on_event(note_event(note, frame))
        else:
            about = frame if note.frame is None else note.frame
            log.log(logging.WARNING if note.warning else logging.INFO, "frame %d: %s", about, note)


def shared_note_event(note: Note, frames: str, count: int) -> dict[str, Any]:
    """Return the event of a note that ``count`` frames share, the range ``frames``; told when all have ended."""
    return {
        "event": "shared-note",
        "frames": frames,
        "count": count,
        "node": note.node or None,
        "level": note.level,
        "text": note.text,
    }


def frame_event(report: FrameReport) -> dict[str, Any]:
    """Return the event of a frame that has ended: status, file (or ``files``), seconds, the error as plain data."""
    return {
        "event": "frame",
        "frame": report.frame,
        "status": report.status,
        "file": report.files[0] if report.files else None,
        "files": list(report.files),
        "seconds": round(report.seconds, 4),
        "error": report.error.to_dict() if report.error else None,
        "message": str(report.error) if report.error else None,
    }


def end_event(report: Report) -> dict[str, Any]:
    """Return the event of a run that has ended: counts by status, seconds, exit code."""
    return {"event": "end", **report.counts, "seconds": round(report.seconds, 4), "exit_code": report.exit_code}


def profile_event(times: Iterable[NodeTime], frame: int | None = None) -> dict[str, Any]:
    """Return the event of the seconds by node of one frame, or (frame None) of the whole run; the slowest first."""
    nodes = [
        {
            "node": each.node,
            "type": each.type,
            "frames": each.frames,
            "runs": each.runs,
            "seconds": round(each.seconds, 4),
            "longest": round(each.longest, 4),
        }
        for each in times
    ]
    return {"event": "profile", "frame": frame, "nodes": nodes}
