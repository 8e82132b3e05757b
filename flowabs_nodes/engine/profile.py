"""Adds up where the time of a run went: seconds by node, over all frames."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class NodeTime:
    """One node's time: on how many frames it ran, its seconds on all of them together, and on the longest.

    Colours are converted when first asked for, so a conversion counts for the node that asked.
    """

    node: str
    type: str
    frames: int
    seconds: float
    longest: float


def total_times(timings: Iterable[Mapping[str, float]], types: Mapping[str, str]) -> tuple[NodeTime, ...]:
    """Add up the seconds by node of all frames; the slowest node comes first. ``types`` gives each node's type."""
    seen: dict[str, list[float]] = {}
    for frame in timings:
        for node, seconds in frame.items():
            seen.setdefault(node, []).append(seconds)
    times = [NodeTime(node, types.get(node, ""), len(each), sum(each), max(each)) for node, each in seen.items()]
    return tuple(sorted(times, key=lambda time: (-time.seconds, time.node)))
