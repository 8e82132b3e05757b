"""Reads the size of the picture that a graph's pixel lengths are meant for: ``"reference_size": {"shorter": 540}``."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from flowabs_nodes.graph.document_keys import NUMBER, read_fields
from flowabs_nodes.graph.problems import Problems, show

#: What may be measured of a display window: its extent in pixels, from width and height.
MEASURES: Mapping[str, Callable[[int, int], float]] = {
    "height": lambda width, height: height,
    "width": lambda width, height: width,
    "shorter": min,
    "diagonal": math.hypot,
}

_PLACE, _OLD_PLACE = ("reference_size",), ("reference_height",)


@dataclass(frozen=True)
class ReferenceSize:
    """Holds what is measured of a display window, a key of :data:`MEASURES`, and the pixels that lengths are meant for.

    ``shorter`` gives a picture the same lengths as one turned on its side.
    """

    measure: str
    pixels: float

    def factor(self, width: int, height: int) -> float:
        """Return the factor by which pixel lengths grow on a display window of ``width`` x ``height`` pixels."""
        return MEASURES[self.measure](width, height) / self.pixels


def read_reference_size(top: Mapping[str, Any], problems: Problems) -> ReferenceSize | None:
    """Return what ``reference_size`` of a document says, or ``reference_height``, its older spelling; None if neither.

    ``top`` holds the entries of the document that are of the right kind. Problems: out-of-range, wrong-type,
    unknown-key, bad-value.
    """
    old, new = top.get("reference_height"), top.get("reference_size")
    if old is not None and new is not None:
        problems.add("bad-value", _PLACE, "reference_height too", "one of reference_size and reference_height")
        return None
    if new is None:
        return None if old is None else _checked("height", old, _OLD_PLACE, problems)
    if len(new) != 1:
        problems.add("bad-value", _PLACE, show(new), f"one of {', '.join(MEASURES)}, as in {{'shorter': 540}}")
        return None
    for measure, pixels in read_fields(new, _PLACE, dict.fromkeys(MEASURES, NUMBER), problems).items():
        return _checked(measure, pixels, (*_PLACE, measure), problems)
    return None


def _checked(measure: str, pixels: float, place: tuple[str, ...], problems: Problems) -> ReferenceSize | None:
    """Return the size, or None where its number of pixels is not above 0."""
    if pixels > 0:
        return ReferenceSize(measure, pixels)
    problems.add("out-of-range", place, show(pixels), "a number of pixels above 0")
    return None
