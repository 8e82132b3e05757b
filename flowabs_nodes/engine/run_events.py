"""Tells a run's events in order: start, notes, nodes at work, frames, what many frames share, the end."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flowabs_nodes.engine.node_events import NodeEvents
from flowabs_nodes.engine.notes import NoteBook, frame_range
from flowabs_nodes.engine.profile import total_times
from flowabs_nodes.engine.report import (
    FrameReport,
    Listener,
    Note,
    Report,
    end_event,
    frame_event,
    note_event,
    profile_event,
    shared_note_event,
    start_event,
)


class RunEvents:
    """Tells the events of one run to ``listener``, if there is one.

    ``types`` are the types of the graph's nodes, by name. With ``profile`` each frame's seconds by node are told.
    ``nodes`` is told by whoever renders a frame what is at work; None where nobody listens.
    """

    def __init__(self, listener: Listener | None, types: Mapping[str, str], *, profile: bool = False) -> None:
        self._listener = listener
        self._types = types
        self._profile = profile
        self._notes = NoteBook()
        self._frames = 0
        self._ended = 0
        self._progress: dict[int, float] = {}  # of the frames that are being made, 0 to 1
        self.nodes = NodeEvents(self.node, types) if listener is not None else None

    def start(self, graph: str, frames: int) -> None:
        """Tell that the run begins: the graph's name, and how many frames there are to make."""
        self._frames = frames
        self._tell(start_event(graph, frames))

    def note(self, note: Note) -> None:
        """Tell a note that is about no frame."""
        self._tell(note_event(note))

    def frame(self, report: FrameReport) -> None:
        """Tell a frame that has ended, after those of its notes that no frame before it had."""
        for note in self._notes.new(report.notes, report.frame):
            self._tell(note_event(note, report.frame))
        self._progress.pop(report.frame, None)
        self._ended += 1
        self._tell(frame_event(report) | {"percent": self._percent})
        if self._profile:
            self._tell(profile_event(total_times(report.timings, self._types), report.frame))

    def end(self, report: Report) -> None:
        """Tell what many frames share, and that the run has ended."""
        for note, frames in self._notes.shared():
            self._tell(shared_note_event(note, frame_range(frames), len(frames)))
        failed = [frame.frame for frame in report.frames if frame.status == "failed"]
        self._tell(end_event(report) | {"failed_frames": frame_range(failed) if failed else None})

    def node(self, event: dict[str, Any]) -> None:
        """Tell that a node is at work, or has ended its work, wherever that is (:class:`NodeEvents`)."""
        self._progress[event["frame"]] = event["progress"]
        self._tell(event | {"percent": self._percent})

    @property
    def _percent(self) -> float:
        """Return how much of the whole run is done, 0 to 100, each frame counting the same."""
        return round(100 * (self._ended + sum(self._progress.values())) / max(1, self._frames), 2)

    def _tell(self, event: dict[str, Any]) -> None:
        if self._listener is not None:
            self._listener(event)
