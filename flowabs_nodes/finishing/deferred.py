"""Pictures with deferred per-pixel operations, done in one pass with the decoding when pixels are asked for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.finishing.operations import Ink, OnRows, Operation, Quantize, RowsFunction
from flowabs_nodes.image import Image

# What numba compiles is imported where it is needed: a node that notes an operation down is declared without.
if TYPE_CHECKING:
    from flowabs_nodes.color.codes import Codes
    from flowabs_nodes.color.spaces import ColorSpace


@dataclass(frozen=True)
class Deferred:
    """Code values, and the operations that are to be done on the pixels they decode to: a ``PixelSource``."""

    codes: Codes
    operations: tuple[Operation, ...]

    @property
    def shape(self) -> tuple[int, int, int]:
        """Return the shape of the picture, (H, W, 3) or (H, W, 4)."""
        return self.codes.shape

    def decode(self, colorspace: ColorSpace) -> Array:
        """Return the finished scene-linear picture: (H, W, 3), or premultiplied (H, W, 4) if ``codes.under`` has alpha.

        It is float32, in ``colorspace``. ArgumentError for code values that are not finite.
        """
        from flowabs_nodes.finishing.finish import finish

        return finish(self.codes, self.operations, colorspace)

    def decode_rows(self, first: int, last: int, colorspace: ColorSpace) -> Array:
        """Return the rows ``first`` .. ``last`` - 1 of :meth:`decode`."""
        from flowabs_nodes.finishing.finish import finish_rows

        return finish_rows(self.codes, self.operations, colorspace, first, last)


def with_operation(image: Image, operation: Quantize | Ink | RowsFunction, node: str = "") -> Image:
    """Return a color image with one more operation on each of its pixels, after those that are noted down already.

    Where a filter left code values, the operation is only noted down, and done in one pass with the decoding when
    pixels are asked for; otherwise it is done now.

    Parameters
    ----------
    operation
        ``Quantize``, ``Ink``, or a function ``operation(rows, first_row)``, which is called for one band of rows after
        another, by several threads at once. ``rows`` is (h, W, 3 or 4) float32, scene-linear and premultiplied;
        ``first_row`` is the number of its first row in the picture. The function changes ``rows`` in place and returns
        None, or returns others of the same shape. A pixel of the result may depend on no other pixel of ``rows``, and
        alpha must stay as it is. Whatever the function needs of other images is asked for before, not inside.
    node
        The node that the function belongs to, ``context.node``: an error in the function is that node's.
    """
    each = operation if isinstance(operation, Quantize | Ink | OnRows) else OnRows(operation, node)
    if image.type != "color":
        raise ArgumentError(f"operations are done on color images, this one is {image.type}", parameter="image")
    source = image.deferred
    if source is not None:
        before = source.operations if isinstance(source, Deferred) else ()
        return image.with_deferred(Deferred(source.codes, (*before, each)))
    from flowabs_nodes.finishing.finish import finish_pixels

    return image.with_pixels(finish_pixels(image.pixels, each, image.colorspace))
