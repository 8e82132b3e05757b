"""Lines for the end of a run: where the time went, which frames failed and why, and how to make these again."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from flowabs_nodes.engine.report import Report


def failed_lines(report: Report, again: Callable[[str], str]) -> list[str]:
    """Return a line for each reason why frames failed, with their range, and the command that makes them again.

    ``again`` returns the command for a range. Frames that a stopped run did not come to are made by it too.
    """
    from flowabs_nodes.engine.notes import frame_range

    reasons: dict[str, list[int]] = {}
    for frame in report.frames:
        if frame.error is not None:
            reasons.setdefault(frame.error.reason, []).append(frame.frame)
    to_make = [frame for frames in reasons.values() for frame in frames] + list(report.not_made)
    if not to_make:
        return []
    lines = [f"  {frames_in_words(frame_range(frames), len(frames))}: {why}" for why, frames in reasons.items()]
    if reasons:
        count = sum(map(len, reasons.values()))
        lines.insert(0, f"{count} frame{'' if count == 1 else 's'} failed:")
    what = "To make just these again:" if reasons and not report.not_made else "To make what is not there:"
    return [*lines, what, f"  {again(frame_range(to_make))}"]


def frames_in_words(frames: str, count: int) -> str:
    """Return "frame 5" or "frames 5-9" for a range and how many frames it holds."""
    return f"frame {frames}" if count == 1 else f"frames {frames}"


def profile_lines(nodes: Iterable[dict[str, Any]]) -> list[str]:
    """Return the lines of a table from the rows of a profile event: seconds and share of each node."""
    rows = list(nodes)
    if not rows:
        return []
    total = sum(each["seconds"] for each in rows) or 1.0
    width = max(len("node"), *(len(each["node"]) for each in rows))
    kinds = max(len("type"), *(len(each["type"]) for each in rows))
    head = f"{'node':{width}}  {'type':{kinds}}  frames  seconds   share  a frame  longest"
    lines = (
        f"{each['node']:{width}}  {each['type']:{kinds}}  {each['frames']:6}  {each['seconds']:7.3f}"
        f"  {each['seconds'] / total:6.1%}  {each['seconds'] / each['frames']:7.3f}  {each['longest']:7.3f}"
        for each in rows
    )
    return ["", head, *lines]
