"""Any list of operations on a picture, in one pass over bands of its rows: a band goes through all of them at once.

Bands are shared among threads like those of a kernel. As each pixel is on its own, their number changes no bit.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.color.spaces import ColorSpace
from flowabs_nodes.errors import FlowabsError, InternalError, unforeseen
from flowabs_nodes.filters.compositing import inked
from flowabs_nodes.finishing.fused import quantized
from flowabs_nodes.finishing.operations import Ink, OnRows, Operation, Quantize
from flowabs_nodes.simd.bands import limited, over_rows


def in_bands(
    shape: tuple[int, ...],
    begin: Callable[[int, int], Array],
    operations: tuple[Operation, ...],
    colorspace: ColorSpace,
) -> Array:
    """Return a picture of ``shape``, (H, W, C) float32, after ``operations``.

    ``begin(first, last)`` returns its rows ``first`` .. ``last`` - 1 before them, in an array that nobody else has.
    ArgumentError where an operation meets pixels that are not finite; InternalError, with the operation's node, for
    whatever else an operation raises.
    """
    pixels = np.empty(shape, np.float32)

    def band(first: int, last: int) -> None:
        """Compute the rows ``first`` .. ``last`` - 1."""
        with limited(1):  # the bands are what threads share
            pixels[first:last] = done(operations, begin(first, last), first, colorspace)

    over_rows(band, shape[0])
    return pixels


def done(operations: tuple[Operation, ...], rows: Array, first: int, colorspace: ColorSpace) -> Array:
    """Return ``rows`` of a picture, the first of which has the number ``first``, after ``operations``."""
    for operation in operations:
        rows = _done(operation, rows, first, colorspace)
    return rows


def _done(operation: Operation, rows: Array, first: int, colorspace: ColorSpace) -> Array:
    """Return ``rows`` of a picture, the first of which has the number ``first``, after one operation."""
    if isinstance(operation, Quantize):
        return quantized(rows, operation.on_rows(first, first + len(rows)), colorspace)
    if isinstance(operation, Ink):
        lines = operation.on_rows(first, first + len(rows)).lines
        return inked(rows, lines, (*operation.color, operation.opacity))
    try:
        return _changed(operation, rows, first)
    except FlowabsError as error:
        raise error.at(node=operation.node or None)  # noqa: B904 - the same error, with its place
    except (MemoryError, KeyboardInterrupt):
        raise
    except BaseException as error:  # or the node that asks for the pixels would be blamed
        raise unforeseen(error).at(node=operation.node or None) from error


def _changed(operation: OnRows, rows: Array, first: int) -> Array:
    """Return ``rows`` as the operation's function changes them. InternalError for what no such function may do."""
    alpha = rows[..., 3:].copy()
    result = operation.function(rows, first)
    result = rows if result is None else result
    if not isinstance(result, np.ndarray) or result.shape != rows.shape or result.dtype.kind not in "fiub":
        found = f"{result.dtype} {result.shape}" if isinstance(result, np.ndarray) else type(result).__name__
        raise InternalError(f"an operation must return float32 rows {rows.shape}, or None, it returned {found}")
    if not np.array_equal(result[..., 3:], alpha, equal_nan=True):
        raise InternalError("an operation must leave alpha as it is")
    return np.ascontiguousarray(result, np.float32)
