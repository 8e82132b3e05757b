"""Where the time went: seconds per node, over all frames of a run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class NodeTime:
    """One node's time: total and longest frame in seconds, and on how many frames it ran.

    Colours are converted when first asked for, so a conversion counts for the node that asked.
    """

    node: str
    type: str
    frames: int
    seconds: float
    longest: float


def total_times(timings: Iterable[Mapping[str, float]], types: Mapping[str, str]) -> tuple[NodeTime, ...]:
    """The times of all frames added up, the slowest node first. ``types`` gives each node's type."""
    seen: dict[str, list[float]] = {}
    for frame in timings:
        for node, seconds in frame.items():
            seen.setdefault(node, []).append(seconds)
    times = [NodeTime(node, types.get(node, ""), len(each), sum(each), max(each)) for node, each in seen.items()]
    return tuple(sorted(times, key=lambda time: (-time.seconds, time.node)))
