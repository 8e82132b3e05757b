"""The per-pixel operations that can be deferred until a picture is decoded.

The kernels of fused.py do ours, :class:`Quantize` and :class:`Ink`. Any other is a function, :class:`OnRows`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from flowabs_nodes.array_types import Array

#: Changes rows of a picture, (h, W, C) float32, scene-linear and premultiplied, in place, or returns others of the same
#: shape. The number is that of the first row. A pixel of the result may depend on no other pixel.
RowsFunction = Callable[[Array, int], Array | None]


class Quantize(NamedTuple):
    """Replace L* by the middle of its bin (section 4.1), by a gain on scene-linear RGB."""

    levels: int  # bins of 0..100
    softness: float  # width of the ramp between bins, as a part of a bin, 0 to 1
    phase: float = 0.0  # shift of the bins, as a part of a bin, 0 to 1
    chroma: float = 1.0  # gain on a* and b*
    by_gradient: float = 0.0  # how far ``rises`` decide how hard a step is, 0 to 1
    hard_gradient: float = 1.0  # rise of L* from which a step is hard
    rises: Array | None = None  # (H, W), rise of L* (filters/regions/rise.py), where ``by_gradient`` is above 0

    def on_rows(self, first: int, last: int) -> Quantize:
        """Return the operation on the rows ``first`` .. ``last`` - 1 alone."""
        return self if self.rises is None else self._replace(rises=self.rises[first:last])


class Ink(NamedTuple):
    """Composite ink over the picture: rgb (1 - k) + color A k with k = (1 - lines) opacity."""

    lines: Array  # (H, W), 1 paper and 0 ink
    color: tuple[float, float, float]  # scene-linear
    opacity: float  # 0 to 1

    def on_rows(self, first: int, last: int) -> Ink:
        """Return the operation on the rows ``first`` .. ``last`` - 1 alone."""
        return self._replace(lines=self.lines[first:last])


class OnRows(NamedTuple):
    """Call a function on the rows of the picture."""

    function: RowsFunction
    node: str = ""  # the node that noted it down, for errors


Operation = Quantize | Ink | OnRows


def fused_with_decoding(space: str, operations: tuple[Operation, ...]) -> tuple[Quantize | None, Ink | None]:
    """Return the first of the ``operations`` that one kernel does while it decodes code values of ``space``.

    Kernels quantise only in "lab", whose code values hold L*, and lay ink over the picture last.
    """
    first, second, *_ = *operations, None, None
    quantize = first if isinstance(first, Quantize) and space == "lab" else None
    ink = first if quantize is None else second
    return quantize, ink if isinstance(ink, Ink) else None
