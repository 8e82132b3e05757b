"""Pictures whose last steps are noted down, to be done with the decoding in one pass once somebody asks for pixels."""

from __future__ import annotations

from dataclasses import dataclass

from flowabs_nodes.array_types import Array
from flowabs_nodes.color.codes import Codes
from flowabs_nodes.color.spaces import ColorSpace
from flowabs_nodes.finishing.fused import finish
from flowabs_nodes.finishing.operations import Operation, fused_together
from flowabs_nodes.image import PixelSource


@dataclass(frozen=True)
class Deferred:
    """Code values, and the operations on the pixels that they decode to."""

    codes: Codes
    operations: tuple[Operation, ...]

    def decode(self, colorspace: ColorSpace) -> Array:
        """Return the finished picture: (H, W, 3), or premultiplied (H, W, 4) where the codes have alpha under them."""
        return finish(self.codes, self.operations, colorspace)


def then(source: PixelSource | None, operation: Operation) -> Deferred | None:
    """Return ``source`` with one more operation to be done; None if the kernel cannot do that one in the same pass."""
    if source is None:
        return None
    operations = (*(source.operations if isinstance(source, Deferred) else ()), operation)
    return Deferred(source.codes, operations) if fused_together(source.codes.space, operations) else None
