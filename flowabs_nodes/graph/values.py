"""What a parameter is set to: a literal, a knob (perhaps through a map), or a curve over frames."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Literal:
    """A value that stands in the graph."""

    value: Any

    def at(self, frame: int, knobs: Mapping[str, Any]) -> Any:
        """The value; frame and knobs do not matter."""
        return self.value


@dataclass(frozen=True)
class FromKnob:
    """The value of a knob, or, with a ``map`` of two points or more, what the map makes of it."""

    knob: str
    map: tuple[tuple[float, float], ...] = ()
    whole: bool = False

    def at(self, frame: int, knobs: Mapping[str, Any]) -> Any:
        """The value for these knobs."""
        value = knobs[self.knob]
        return _rounded(interpolate(self.map, value), self.whole) if self.map else value


@dataclass(frozen=True)
class Curve:
    """A value that moves from key to key, each a frame and a number."""

    keys: tuple[tuple[int, float], ...]
    whole: bool = False

    def at(self, frame: int, knobs: Mapping[str, Any]) -> Any:
        """The value at a frame."""
        return _rounded(interpolate(self.keys, frame), self.whole)


Value = Literal | FromKnob | Curve


def interpolate(points: Sequence[tuple[float, float]], x: float) -> float:
    """Linear between points whose x increase, held beyond the ends; at a point exactly its y."""
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
    """Whole numbers are rounded, a half upwards."""
    return math.floor(value + 0.5) if whole else value
