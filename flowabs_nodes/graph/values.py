"""Holds what a parameter is set to: a literal, a knob (perhaps through a map), or a curve over frames."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Literal:
    """Holds a value as it stands in the graph."""

    value: Any

    def at(self, frame: int, knobs: Mapping[str, Any]) -> Any:
        """Return the value, which depends on neither frame nor knobs."""
        return self.value


@dataclass(frozen=True)
class FromKnob:
    """Takes the value of a knob, or, with a ``map`` of two points or more, what the map makes of it.

    ``whole`` rounds the result of the map, for a parameter that takes whole numbers.
    """

    knob: str
    map: tuple[tuple[float, float], ...] = ()
    whole: bool = False

    def at(self, frame: int, knobs: Mapping[str, Any]) -> Any:
        """Return the value for these knobs, which does not depend on the frame."""
        value = knobs[self.knob]
        return _rounded(interpolate(self.map, value), self.whole) if self.map else value


@dataclass(frozen=True)
class Curve:
    """Moves from key to key, each a frame and a number; ``whole`` rounds, for a parameter that takes whole numbers."""

    keys: tuple[tuple[int, float], ...]
    whole: bool = False

    def at(self, frame: int, knobs: Mapping[str, Any]) -> Any:
        """Return the value at a frame, which does not depend on knobs."""
        return _rounded(interpolate(self.keys, frame), self.whole)


Value = Literal | FromKnob | Curve


def interpolate(points: Sequence[tuple[float, float]], x: float) -> float:
    """Return y at ``x``: linear between points whose x increase, held beyond the ends, and at a point exactly its y."""
    i = bisect_right(points, x, key=lambda point: point[0])
    if i == 0:
        return points[0][1]
    if i == len(points) or points[i - 1][0] == x:
        return points[i - 1][1]
    (x0, y0), (x1, y1) = points[i - 1], points[i]
    t = (x - x0) / (x1 - x0)
    y = (1 - t) * y0 + t * y1  # does not overflow, as y1 - y0 may
    return min(max(y, min(y0, y1)), max(y0, y1))  # rounding must not leave the range


def _rounded(value: float, whole: bool) -> float:
    """Return the value, rounded (a half upwards) if it has to be a whole number."""
    return math.floor(value + 0.5) if whole else value
