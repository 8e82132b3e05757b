"""Renders a frame again where a disk or the network failed for a moment; bad data stays bad, and is not tried again."""

from __future__ import annotations

import errno
import time
from collections.abc import Mapping
from dataclasses import replace

from flowabs_nodes import stopping
from flowabs_nodes.engine.carry_over import CarryOver
from flowabs_nodes.engine.existing import State
from flowabs_nodes.engine.job import Job
from flowabs_nodes.engine.node_events import NodeEvents
from flowabs_nodes.engine.render_frame import render_frame
from flowabs_nodes.engine.report import FrameReport, Note
from flowabs_nodes.io.claim_watch import ClaimWatch

#: What the system says of a disk or a network that may answer a moment later.
_MAY_PASS = frozenset(
    getattr(errno, name)
    for name in (
        *("EIO", "ESTALE", "ETIMEDOUT", "EAGAIN", "EBUSY", "EINTR"),
        *("ENETDOWN", "ENETUNREACH", "ECONNRESET"),
    )
    if hasattr(errno, name)
)

#: Seconds before the first further try; each pause is twice the one before it, up to the longest.
PAUSE = 0.5
LONGEST_PAUSE = 8.0
_LOOK = 0.05  # seconds between two looks at whether the run is to stop


def render_with_retries(
    job: Job,
    frame: int,
    carried: CarryOver | None = None,
    *,
    watch: ClaimWatch | None = None,
    left: Mapping[str, State] | None = None,
    nodes: NodeEvents | None = None,
) -> FrameReport:
    """Render one frame as :func:`render_frame` does, up to ``job.options.retries`` times more if what failed may pass.

    The report's warnings say why it was rendered again; its seconds are those of all tries and pauses.
    Raises :class:`~flowabs_nodes.stopping.Stopped` where the run is to stop.
    """
    start = time.perf_counter()
    warnings: list[Note] = []
    while True:
        report = render_frame(job, frame, carried, watch=watch, left=left, nodes=nodes)
        passing = passing_failure(report.error)
        if passing is None or len(warnings) == job.options.retries:
            break
        pause = min(PAUSE * 2 ** len(warnings), LONGEST_PAUSE)
        where = f"{passing.filename}: " if passing.filename else ""
        text = f"{where}{passing.strerror or passing}: rendered again after {pause:g} s"
        warnings.append(Note(text, report.error.node or "" if report.error else "", warning=True, frame=frame))
        _wait(pause)
    if not warnings:
        return report
    return replace(report, notes=(*warnings, *report.notes), seconds=time.perf_counter() - start)


def passing_failure(error: BaseException | None) -> OSError | None:
    """Return the failure of the system behind an error, if it is one that may pass; else None."""
    seen: set[int] = set()
    while error is not None and id(error) not in seen:
        seen.add(id(error))
        if isinstance(error, OSError) and error.errno in _MAY_PASS:
            return error
        error = error.__cause__
    return None


def _wait(seconds: float) -> None:
    """Wait, unless the run is to stop."""
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        stopping.check()
        time.sleep(min(_LOOK, left))
