"""Reports what became of each frame and of the whole run, as objects and as plain events."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from flowabs_nodes.engine.profile import NodeTime
from flowabs_nodes.errors import FlowabsError

Status = Literal["done", "skipped", "failed"]

#: A function that is called with each event of a run, a plain dict, in order: :func:`start_event` and those below it.
Listener = Callable[[dict[str, Any]], None]


@dataclass(frozen=True, slots=True)
class Note:
    """Something to tell the person who runs the graph.

    ``once``: tell it only once per run, node and this word. ``frame``: the frame that it is about, where that may be
    another one than the frame being rendered.
    """

    text: str
    node: str = ""
    warning: bool = False
    once: str = ""
    frame: int | None = None

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
    timings: Mapping[str, float] = field(default_factory=dict)

    def __repr__(self) -> str:
        what = self.error.message.partition("\n")[0] if self.error else ", ".join(self.files)
        return f"<FrameReport of frame {self.frame}: {self.status}, {self.seconds:.2f} s{': ' if what else ''}{what}>"


@dataclass(frozen=True, slots=True)
class Report:
    """A whole run. ``exit_code`` is what a process should exit with: 0, 1 for a failed frame, 130 or 143 if stopped."""

    frames: tuple[FrameReport, ...]
    exit_code: int
    seconds: float = 0.0
    notes: tuple[Note, ...] = ()
    profile: tuple[NodeTime, ...] | None = None

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

    A note that knows its frame goes before ``frame``.
    """
    level = "warning" if note.warning else "note"
    frame = frame if note.frame is None else note.frame
    return {"event": "note", "frame": frame, "node": note.node or None, "level": level, "text": note.text}


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
