"""Shares a sequence with other runs: each leaves the others' frames to them, and waits for these at its end."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

from flowabs_nodes import stopping
from flowabs_nodes.engine.existing import State, state_of
from flowabs_nodes.engine.job import Job
from flowabs_nodes.engine.report import FrameReport, Note
from flowabs_nodes.errors import WriteError
from flowabs_nodes.io.claim_files import Writer
from flowabs_nodes.io.claim_watch import ClaimWatch

#: Seconds between two looks at a frame that another run is writing.
POLL = 0.25
#: Seconds after which those who wait say again what they wait for.
REMIND = 60.0

#: Renders a frame that was left to another run, given the states of its files at that time.
Render = Callable[[int, Mapping[str, State]], FrameReport]


class SharedSequence:
    """The frames of a job that other runs are writing, and what was seen of these runs."""

    def __init__(self, job: Job, numbers: tuple[int, ...]) -> None:
        self.watch = ClaimWatch()
        self._job = job
        self._numbers = numbers
        self._left: dict[int, dict[str, State]] = {}

    def sweep(self) -> None:
        """Remove what runs that have ended left beside the outputs of this one, in each folder listed once."""
        patterns: dict[str, list[str]] = {}
        for pattern in (pattern for patterns in self._job.outputs.values() for pattern in patterns):
            folder, name = os.path.split(pattern)
            patterns.setdefault(folder or ".", []).append(name)
        for folder, names in patterns.items():
            self.watch.sweep(folder, *names, frames=self._numbers)

    def leaves(self, report: FrameReport) -> bool:
        """Return True for a frame that failed only because another run is writing it, and leave it to that run."""
        if report.error is None or report.error.code != "claimed":
            return False
        self._left[report.frame] = {path: state_of(path) for path in report.files}
        return True

    def settle(self, render: Render, tell: Callable[[Note], None]) -> Iterator[FrameReport]:
        """Wait until no living run writes the frames that were left, and yield what became of each.

        A frame that another run made is skipped. One that it failed on, or did not live to finish, is rendered here.
        ``tell`` is told what is waited for, once a minute. Raises Stopped where the run is to stop.
        """
        told = -REMIND
        while self._left:
            writers: dict[int, Writer] = {}
            for frame, before in list(self._left.items()):
                writer = self._writer_of(before)
                if writer is not None:
                    writers[frame] = writer
                    continue
                report = render(frame, before)
                if report.error is not None and report.error.code == "claimed":
                    continue  # another run was faster
                del self._left[frame]
                if report.status == "skipped" and report.files:
                    report = replace(report, notes=(*report.notes, Note("made by another run")))
                yield report
            if writers and time.monotonic() - told >= REMIND:
                told = time.monotonic()
                tell(_waiting_for(writers))
            if self._left:
                stopping.check()
                time.sleep(POLL)

    def _writer_of(self, paths: Mapping[str, State]) -> Writer | None:
        """Return a living run that writes one of a frame's files; None where none does."""
        try:
            return next((writer for path in paths if (writer := self.watch.writer_of(path))), None)
        except WriteError:  # raised again, and told, when the frame is rendered
            return None


def _waiting_for(writers: Mapping[int, Writer]) -> Note:
    """Return the line that says which frames are waited for, and who writes them."""
    frames: dict[Writer, list[int]] = {}
    for frame, writer in writers.items():
        frames.setdefault(writer._replace(token=""), []).append(frame)
    groups = [
        f"{'frame' if len(numbers) == 1 else 'frames'} {', '.join(map(str, numbers))} by {writer}"
        for writer, numbers in frames.items()
    ]
    return Note(f"waiting for what other runs are writing: {'; '.join(groups)}")
