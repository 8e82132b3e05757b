"""Runs a task of an Open Job Description job, and tells the farm how it goes in the lines that it listens to.

``openjd_progress`` is the share of the task's frames that have ended, in percent; ``openjd_status`` says what is
done, ``openjd_fail`` why a frame or the task failed. All other lines are for the log.
Source: the specification's "How Jobs Are Run", section "Stdout/Stderr Messages".
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.engine.render_sequence import render_sequence
from flowabs_nodes.errors import CommandError, FlowabsError
from flowabs_nodes.submit.openjd_frames import from_openjd


def enter(folder: Path | None) -> None:
    """Make ``folder`` the current one, if it is given. Raises CommandError where that cannot be."""
    if folder is None:
        return
    try:
        os.chdir(folder)
    except OSError as error:
        raise CommandError(
            f"the job's folder is not to be had here: {error.strerror}",
            code="no-folder",
            file=os.fspath(folder),
            hint="give the job's parameter Folder: a folder that this machine sees too",
        ) from None


@contextmanager
def failing() -> Iterator[None]:
    """Inside, tell the farm of an error because of which the task cannot begin; it is raised on."""
    try:
        yield
    except FlowabsError as error:
        _say("openjd_fail", str(error))
        raise


def run_task(graph: str, options: Mapping[str, Any]) -> int:
    """Run a graph with the options of a run, ``frames`` in the form of OpenJD, and return the exit code.

    Raises what a run raises before its first frame, and CommandError where ``frames`` is no range of OpenJD.
    """
    frames = options.get("frames")
    if frames is not None:
        try:
            frames = from_openjd(frames)
        except ValueError as error:
            raise CommandError(f"--frames: {error}", code="bad-frames") from None
    return render_sequence(graph, RunOptions(**{**options, "frames": frames}), on_event=_TaskLines().event).exit_code


class _TaskLines:
    """Print a line or two for each event of a run that a farm wants to know of."""

    def __init__(self) -> None:
        self._asked = 0
        self._ended = 0

    def event(self, event: Mapping[str, Any]) -> None:
        """Print what an event says."""
        match event["event"]:
            case "start":
                self._asked = event["frames"]
                _say("openjd_status", f"{event['graph']}: {self._asked} frame{'' if self._asked == 1 else 's'} to make")
            case "note" | "shared-note" if event["level"] == "warning":
                node = f"{event['node']}: " if event["node"] else ""
                _say("warning", f"{node}{event['text']}")
            case "frame":
                self._frame(event)

    def _frame(self, event: Mapping[str, Any]) -> None:
        """Print how a frame ended, and how many have."""
        self._ended += 1
        if event["status"] == "failed":
            frame = f"frame {event['frame']}: "
            _say("openjd_fail", frame + event["message"].replace(frame, "", 1))
        _say("openjd_status", f"frame {event['frame']} {event['status']}, {self._ended} of {self._asked}")
        _say("openjd_progress", f"{100 * self._ended / self._asked:.1f}")


def _say(kind: str, text: str) -> None:
    """Print one line, at once."""
    print(f"{kind}: {' '.join(text.split())}", flush=True)
