"""Adds up where the time of a run went: seconds by node, over one frame or all."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from flowabs_nodes.engine.stopwatch import Timing


@dataclass(frozen=True, slots=True)
class NodeTime:
    """One node's time: on how many frames it ran, its seconds on all of them together, and those of its longest run.

    ``runs`` is how often it ran: more often than ``frames`` where results that other frames ask for again were not
    held. A node runs on more frames than are rendered where others look at the frames before and after.

    ``node`` is in brackets for work that belongs to no single node: "(keys)" is hashing what is read and looking at
    what is there; "(finishing comp)" makes the pixels of what ``comp`` hands on, with all that nodes before it only
    noted down; "(decoding smooth)" is the same without such notes. A conversion to code values counts for the node
    that first asks for it.
    """

    node: str
    type: str
    frames: int
    seconds: float
    longest: float
    runs: int = 0


def total_times(timings: Iterable[Timing], types: Mapping[str, str]) -> tuple[NodeTime, ...]:
    """Add up the seconds by node; the slowest node comes first. ``types`` gives each node's type."""
    seen: dict[str, list[Timing]] = {}
    for timing in timings:
        seen.setdefault(timing.work, []).append(timing)
    times = []
    for node, each in seen.items():
        seconds = [timing.seconds for timing in each]
        frames = len({timing.frame for timing in each})
        times.append(NodeTime(node, types.get(node, ""), frames, sum(seconds), max(seconds), len(each)))
    return tuple(sorted(times, key=lambda time: (-time.seconds, time.node)))
