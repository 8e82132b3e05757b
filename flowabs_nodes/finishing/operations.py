"""What may be done to each pixel of a picture on its own, at the end: declared here, done in fused.py."""

from __future__ import annotations

from typing import NamedTuple

from flowabs_nodes.array_types import Array


class Quantize(NamedTuple):
    """L* to the middle of its bin (section 4.1), by a gain on scene-linear RGB."""

    levels: int  # bins of 0..100
    softness: float  # of the step from one bin to the next, 0 to 1


class Ink(NamedTuple):
    """Lines laid over the picture: rgb (1 - k) + color A k with k = (1 - lines) opacity."""

    lines: Array  # (H, W), 1 paper and 0 ink
    color: tuple[float, float, float]  # scene-linear
    opacity: float


Operation = Quantize | Ink


def split(operations: tuple[Operation, ...]) -> tuple[Quantize | None, Ink | None]:
    """Return the quantisation and the ink among operations that :func:`fused_together` accepts."""
    quantize = next((each for each in operations if isinstance(each, Quantize)), None)
    return quantize, next((each for each in operations if isinstance(each, Ink)), None)


def fused_together(space: str, operations: tuple[Operation, ...]) -> bool:
    """Whether decoding from ``space`` and these operations are one pass: L* is at hand in "lab", and ink comes last."""
    kinds = [type(operation) for operation in operations]
    return kinds in ([Quantize], [Ink], [Quantize, Ink]) and (space == "lab" or kinds == [Ink])
