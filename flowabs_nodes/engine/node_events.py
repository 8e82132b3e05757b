"""Tells which node is at work, and how far its frame is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from flowabs_nodes.engine.plan import Step
from flowabs_nodes.engine.report import Listener


class NodeEvents:
    """Tells ``listener`` when a node begins and ends, on one frame after the other (:class:`Watcher`).

    A frame's progress is the share of the work that is done. Each node counts by the least seconds that it took so far:
    the first time, kernels may have been compiled. One that has not run yet counts as the average node, so on the first
    frame all count the same.
    """

    def __init__(self, listener: Listener, types: Mapping[str, str]) -> None:
        self._listener = listener
        self._types = types
        self._least: dict[str, float] = {}  # seconds by node
        self._frame = 0
        self._depth = 0  # how many pieces of work are going on, one inside the other
        self._weights: dict[str, float] = {}
        self._done = 0.0
        self._total = 0.0

    def begin_frame(self, frame: int) -> None:
        """Take note that a frame is begun, of which nothing is planned yet."""
        self._frame, self._depth = frame, 0
        self._weights, self._done, self._total = {}, 0.0, 0.0

    def plan(self, steps: Iterable[Step]) -> None:
        """Take note of the work that the frame needs from now on."""
        average = sum(self._least.values()) / len(self._least) if self._least else 1.0
        nodes = [step.unit.node for step in steps]
        self._weights = {node: self._least.get(node, average) for node in nodes}
        self._done, self._total = 0.0, sum(self._weights[node] for node in nodes)

    def begins(self, work: str) -> None:
        """Tell that a piece of work begins."""
        self._depth += 1
        self._tell(work, "started", None)

    def ends(self, work: str, seconds: float) -> None:
        """Tell that a piece of work has ended."""
        self._depth -= 1
        if self._depth == 0 and work in self._types:
            self._least[work] = min(seconds, self._least.get(work, seconds))
            self._done += self._weights.get(work, 0.0)
        self._tell(work, "done", round(seconds, 4))

    def _tell(self, work: str, status: str, seconds: float | None) -> None:
        event: dict[str, Any] = {
            "event": "node",
            "frame": self._frame,
            "node": work,
            "type": self._types.get(work, ""),
            "status": status,
            "seconds": seconds,
            "progress": round(min(1.0, self._done / self._total), 4) if self._total else 0.0,
        }
        self._listener(event)
