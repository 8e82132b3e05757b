"""Pictures with deferred per-pixel operations, done in one pass with the decoding when pixels are asked for."""

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
    """Code values, and the operations that are to be done on the pixels they decode to: a ``PixelSource``."""

    codes: Codes
    operations: tuple[Operation, ...]

    def decode(self, colorspace: ColorSpace) -> Array:
        """Return the finished scene-linear picture: (H, W, 3), or premultiplied (H, W, 4) if ``codes.under`` has alpha.

        It is float32, in ``colorspace``. ArgumentError for code values that are not finite.
        """
        return finish(self.codes, self.operations, colorspace)


def then(source: PixelSource | None, operation: Operation) -> Deferred | None:
    """Return ``source`` with one more deferred operation, or None if the fused kernel cannot do all of them in a pass.

    None also for a ``source`` of None: an image whose pixels are there already.
    """
    if source is None:
        return None
    operations = (*(source.operations if isinstance(source, Deferred) else ()), operation)
    return Deferred(source.codes, operations) if fused_together(source.codes.space, operations) else None
