"""The pens that the kinds of lines from passes are drawn with."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

#: The widest line in pixels: distances are known up to 10.
WIDEST = 8.0


class Pen(NamedTuple):
    """What one kind of line looks like."""

    width: float  # pixels, 0 to 8; 0 draws nothing
    color: tuple[float, float, float] = (0.0, 0.0, 0.0)  # scene-linear
    opacity: float = 1.0


#: The pen of each kind of line, the upper ones first.
PENS: Mapping[str, Pen] = MappingProxyType(
    {"outline": Pen(2.0), "object": Pen(1.5), "material": Pen(1.0), "crease": Pen(1.0), "intersection": Pen(1.0)}
)
