"""Translate frame ranges between ours and those of Open Job Description (OpenJD), which write a step as ``:``."""

from __future__ import annotations

import re
from collections.abc import Iterable

_PART = re.compile(r"(-?\d+)(?:-(-?\d+)(?::(\d+))?)?")


def from_openjd(text: str) -> str:
    """Return a range of OpenJD such as ``1001-1100:2,1200`` as ``--frames`` takes it: ``1001-1100x2,1200``.

    Raises ValueError where the text is no range of OpenJD.
    """
    parts = [part.strip() for part in text.split(",")]
    for part in parts:
        if not _PART.fullmatch(part):
            raise ValueError(f"{part!r} is not a range of Open Job Description such as 1001-1100:2")
    return ",".join(part.replace(":", "x") for part in parts)


def to_openjd(frames: Iterable[int]) -> str:
    """Return frames, in rising order and each once, as a range of OpenJD: its parts must not overlap."""
    left = sorted(set(frames))
    parts = []
    while left:
        step = left[1] - left[0] if len(left) > 1 else 1
        count = 1
        while count < len(left) and left[count] - left[count - 1] == step:
            count += 1
        if count == 2 and step > 1:  # two frames with a gap: the second may begin a run
            count = 1
        first, last = left[0], left[count - 1]
        parts.append(str(first) if count == 1 else f"{first}-{last}" + (f":{step}" if step > 1 else ""))
        del left[:count]
    return ",".join(parts)
