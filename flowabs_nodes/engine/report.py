"""What became of each frame and of the whole run, and the same as plain events."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from flowabs_nodes.engine.profile import NodeTime
from flowabs_nodes.errors import FlowabsError

Status = Literal["done", "skipped", "failed"]

#: Gets each event of a run as a plain dict, in order; see :func:`note_event`, :func:`frame_event`.
Listener = Callable[[dict[str, Any]], None]


@dataclass(frozen=True, slots=True)
class Note:
    """Something to tell the person who runs the graph. What has ``once`` is said once per run, node and that word."""

    text: str
    node: str = ""
    warning: bool = False
    once: str = ""

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


@dataclass(frozen=True, slots=True)
class Report:
    """A whole run. ``exit_code`` is what a process should exit with: 0, 1 for a failed frame, 130 or 143 if stopped."""

    frames: tuple[FrameReport, ...]
    exit_code: int
    seconds: float = 0.0
    notes: tuple[Note, ...] = ()
    profile: tuple[NodeTime, ...] | None = None

    @property
    def counts(self) -> dict[str, int]:
        """How many frames are done, skipped, failed."""
        counts = {"done": 0, "skipped": 0, "failed": 0}
        for frame in self.frames:
            counts[frame.status] += 1
        return counts


# ---------------------------------------------------------------------- events: one a line with --json


def start_event(graph: str, frames: int) -> dict[str, Any]:
    """The run begins: graph's name, how many frames."""
    return {"event": "start", "graph": graph, "frames": frames}


def note_event(note: Note, frame: int | None = None) -> dict[str, Any]:
    """Something to know about a frame, or (frame None) about the graph; ``level`` is "note" or "warning"."""
    level = "warning" if note.warning else "note"
    return {"event": "note", "frame": frame, "node": note.node or None, "level": level, "text": note.text}


def frame_event(report: FrameReport) -> dict[str, Any]:
    """A frame has ended: its status, the file (``files``, where there are several), seconds, error as plain data."""
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
    """The run has ended: counts by status, seconds, exit code."""
    return {"event": "end", **report.counts, "seconds": round(report.seconds, 4), "exit_code": report.exit_code}
