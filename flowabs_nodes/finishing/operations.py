"""The per-pixel operations that can be deferred until a picture is decoded; the kernels of fused.py do them."""

from __future__ import annotations

from typing import NamedTuple

from flowabs_nodes.array_types import Array


class Quantize(NamedTuple):
    """Replace L* by the middle of its bin (section 4.1), by a gain on scene-linear RGB."""

    levels: int  # bins of 0..100
    softness: float  # width of the ramp between bins, as a part of a bin, 0 to 1


class Ink(NamedTuple):
    """Composite ink over the picture: rgb (1 - k) + color A k with k = (1 - lines) opacity."""

    lines: Array  # (H, W), 1 paper and 0 ink
    color: tuple[float, float, float]  # scene-linear
    opacity: float  # 0 to 1


Operation = Quantize | Ink


def split(operations: tuple[Operation, ...]) -> tuple[Quantize | None, Ink | None]:
    """Return the quantisation and the ink among operations that :func:`fused_together` accepts."""
    quantize = next((each for each in operations if isinstance(each, Quantize)), None)
    return quantize, next((each for each in operations if isinstance(each, Ink)), None)


def fused_together(space: str, operations: tuple[Operation, ...]) -> bool:
    """Return whether one kernel decodes code values of ``space`` and does these operations, in this order.

    Kernels quantise only in "lab", whose code values hold L*, and lay ink over the picture last.
    """
    kinds = [type(operation) for operation in operations]
    return kinds in ([Quantize], [Ink], [Quantize, Ink]) and (space == "lab" or kinds == [Ink])
