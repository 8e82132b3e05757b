"""Says which frames a sequence lacks between its first and its last, where every frame on disk is rendered."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from flowabs_nodes.engine.report import Note

_SHOWN = 8  # holes


def holes(numbers: Sequence[int]) -> tuple[Note, ...]:
    """Return a warning that names the frames that are not among ``numbers``, which are in order; none where all are.

    A sequence of at least four frames with the same step between all of them, such as 1, 3, 5, 7, has no holes.
    """
    steps = {after - before for before, after in pairwise(numbers)}
    if steps <= {1} or (len(steps) == 1 and len(numbers) > 3):
        return ()
    found = [(before + 1, after - 1) for before, after in pairwise(numbers) if after - before > 1]
    shown = ", ".join(f"{first}-{last}" if first < last else f"{first}" for first, last in found[:_SHOWN])
    more = ", ..." if len(found) > _SHOWN else ""
    one = len(found) == 1 and found[0][0] == found[0][1]
    text = f"frame {shown} is not on disk" if one else f"frames {shown}{more} are not on disk"
    return (Note(f"{text} and not made; --frames {numbers[0]}-{numbers[-1]} asks for every frame", warning=True),)
