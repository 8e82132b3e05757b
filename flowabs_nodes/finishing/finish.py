"""Finish a picture: decode it and do the operations on its pixels, by the one fused kernel where that does them all."""

from __future__ import annotations

from flowabs_nodes.array_types import Array
from flowabs_nodes.color.codes import Codes
from flowabs_nodes.color.spaces import ColorSpace
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters.compositing import inked
from flowabs_nodes.finishing.fused import decoded, quantized
from flowabs_nodes.finishing.in_bands import done, in_bands
from flowabs_nodes.finishing.operations import Ink, Operation, Quantize, fused_with_decoding


def finish(codes: Codes, operations: tuple[Operation, ...], colorspace: ColorSpace) -> Array:
    """Return the picture that code values decode to in ``colorspace``, with ``operations`` done on its pixels in order.

    The result is scene-linear float32, (H, W, 3), or premultiplied (H, W, 4) if ``codes.under`` has alpha.
    ArgumentError for code values that are not finite; others are those of
    :func:`~flowabs_nodes.finishing.in_bands.in_bands`.
    """
    quantize, ink = fused_with_decoding(codes.space, operations)
    rest = operations[(quantize is not None) + (ink is not None) :]
    if not rest:
        return decoded(codes, quantize, ink, colorspace)

    def begin(first: int, last: int) -> Array:
        """Return decoded rows."""
        try:
            return _decoded_rows(codes, quantize, ink, colorspace, first, last)
        except ArgumentError:
            decoded(codes, quantize, ink, colorspace)  # counts and places what is wrong in the whole picture
            raise

    return in_bands(codes.shape, begin, rest, colorspace)


def finish_rows(
    codes: Codes, operations: tuple[Operation, ...], colorspace: ColorSpace, first: int, last: int
) -> Array:
    """Return the rows ``first`` .. ``last`` - 1 of what :func:`finish` returns; places in errors are among these rows.

    Whoever works on a band of rows at a time needs no memory for the whole picture.
    """
    quantize, ink = fused_with_decoding(codes.space, operations)
    rest = operations[(quantize is not None) + (ink is not None) :]
    return done(rest, _decoded_rows(codes, quantize, ink, colorspace, first, last), first, colorspace)


def _decoded_rows(
    codes: Codes, quantize: Quantize | None, ink: Ink | None, colorspace: ColorSpace, first: int, last: int
) -> Array:
    """Return the rows ``first`` .. ``last`` - 1 of what :func:`~flowabs_nodes.finishing.fused.decoded` returns."""
    under = None if codes.under is None else codes.under[first:last]
    flat = None if quantize is None else quantize.on_rows(first, last)
    lines = None if ink is None else ink.on_rows(first, last)
    return decoded(Codes(codes.values[first:last], codes.space, under), flat, lines, colorspace)


def finish_pixels(pixels: Array, operation: Operation, colorspace: ColorSpace) -> Array:
    """Return a picture (H, W, C) of float32 pixels after one operation; errors are those of :func:`finish`."""
    if isinstance(operation, Quantize):
        return quantized(pixels, operation, colorspace)
    if isinstance(operation, Ink):
        return inked(pixels, operation.lines, (*operation.color, operation.opacity))
    return in_bands(pixels.shape, lambda first, last: pixels[first:last].copy(), (operation,), colorspace)
