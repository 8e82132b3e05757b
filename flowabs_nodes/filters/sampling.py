"""Reading a picture at points: at the nearest pixel, or bilinearly.

Points are offsets from the pixels of a block, in float64, so that how they round does not depend on where the pixel
lies. They may lie anywhere: their coordinates are clamped to the picture, which repeats its border.

Pictures are :func:`records`: one float a pixel, or four whatever their number of channels, because one 128-bit load
fetches four floats as fast as one. No faster way was found to read at scattered places than one load a pixel (gathers
are slower).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.extending import intrinsic

from flowabs_nodes.filters.arguments import Array
from flowabs_nodes.filters.blocks import Block, inline, scratch, u

SAMPLINGS = ("bilinear", "nearest")


class Between(NamedTuple):
    """Where in the picture points are, to read it bilinearly."""

    pixel: Any  # the upper left of the four around a point
    fx: Any  # how far beyond it the point is, 0..1
    fy: Any


def records(image: Array) -> Array:
    """(H, W) or (H, W, C) with up to four channels as (H, W, 1) or, the last ones 0, (H, W, 4).

    Pictures one pixel wide are (H, W, 4): of one channel, readings take in the neighbour on the right.
    """
    channels = image if image.ndim == 3 else image[..., None]
    _, width, count = channels.shape
    if count == 4 or (count == 1 and width > 1):
        return channels
    result = np.zeros((*channels.shape[:2], 4), np.float32)
    result[..., :count] = channels
    return result


@inline
def nearest(dx: Any, dy: Any, pixel: Any, block: Block) -> None:
    """``pixel``: the one nearest to each point, its offset rounded half to even."""
    right, bottom = block.width - 1.0, block.height - 1.0
    for i in range(block.size):
        x = min(max(np.rint(dx[i]) + (np.float64(block.x) + np.float64(np.int32(i))), 0.0), right)
        y = min(max(np.rint(dy[i]) + np.float64(block.y), 0.0), bottom)
        pixel[i] = np.int32(y * np.float64(block.width) + x)


@inline
def snap(dx: Any, dy: Any, to_dx: Any, to_dy: Any, block: Block) -> None:
    """Offsets of the pixel nearest to each point."""
    right, bottom = block.width - 1.0, block.height - 1.0
    for i in range(block.size):
        x, y = np.float64(block.x) + np.float64(np.int32(i)), np.float64(block.y)
        to_dx[i] = min(max(np.rint(dx[i]) + x, 0.0), right) - x
        to_dy[i] = min(max(np.rint(dy[i]) + y, 0.0), bottom) - y


@inline
def new_between() -> Between:
    return Between(scratch(np.int32, 1), scratch(np.float32, 1), scratch(np.float32, 1))


@inline
def find(dx: Any, dy: Any, between: Between, block: Block) -> None:
    """Where each point is."""
    right, bottom = block.width - 1.0, block.height - 1.0
    last_x, last_y = max(block.width - 2.0, 0.0), max(block.height - 2.0, 0.0)
    for i in range(block.size):
        x = min(max(dx[i] + (np.float64(block.x) + np.float64(np.int32(i))), 0.0), right)
        y = min(max(dy[i] + np.float64(block.y), 0.0), bottom)
        left, top = min(np.floor(x), last_x), min(np.floor(y), last_y)
        between.pixel[i] = np.int32(top * np.float64(block.width) + left)
        between.fx[i] = np.float32(x - left)
        between.fy[i] = np.float32(y - top)


@inline
def read(image: Any, pixel: Any, values: Any, block: Block, channels: int = 4) -> None:
    """``values``: the records of ``image`` at ``pixel``."""
    if channels == 1:
        for i in range(block.size):
            _copy(values, i, image, u(np.uint32(pixel[i])), 1)
    else:
        for i in range(block.size):
            _copy(values, u(4) * i, image, u(4) * u(np.uint32(pixel[i])), 4)


@inline
def read_between(image: Any, between: Between, values: Any, block: Block, channels: int = 4) -> None:
    """``values``: the records of ``image``, bilinearly."""
    right = u(4 if block.width > 1 else 0)
    below = u(channels * block.width if block.height > 1 else 0)
    if channels == 1:
        around = scratch(np.float32, 4)
        for i in range(block.size):
            j = u(np.uint32(between.pixel[i]))
            _copy(around, u(4) * i, image, j, 2)
            _copy(around, u(4) * i + u(2), image, j + below, 2)
        for i in range(block.size):
            a, b, c, d = around[u(4) * i], around[u(4) * i + u(1)], around[u(4) * i + u(2)], around[u(4) * i + u(3)]
            upper, lower = a + between.fx[i] * (b - a), c + between.fx[i] * (d - c)
            values[i] = upper + between.fy[i] * (lower - upper)
    else:
        for i in range(block.size):
            j = u(4) * u(np.uint32(between.pixel[i]))
            _blend(values, u(4) * i, image, j, right, below, between.fx[i], between.fy[i])


@inline
def read_tangents(flow: Any, pixel: Any, values: Any, block: Block) -> None:
    """``values``: the tangents at ``pixel``, x and y in turn."""
    for i in range(block.size):
        _copy(values, u(2) * i, flow, u(2) * u(np.uint32(pixel[i])), 2)


@intrinsic
def _copy(typingctx: Any, to: Any, i: Any, source: Any, j: Any, count: Any) -> Any:
    """to[i : i + count] = source[j : j + count], in one go; ``count`` is a constant."""
    if not isinstance(count, types.IntegerLiteral):
        return None  # numba asks again with the constant

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        vector = ir.VectorType(ir.FloatType(), count.literal_value)
        address = _addressing(context, builder, signature, arguments, vector)
        _store(builder, _load(builder, address(2, arguments[3])), address(0, arguments[1]))
        return context.get_dummy_value()

    return types.void(to, i, source, j, count), codegen


@intrinsic
def _blend(typingctx: Any, to: Any, i: Any, source: Any, j: Any, right: Any, below: Any, fx: Any, fy: Any) -> Any:
    """to[i : i + 4] = the records at ``j``, ``right`` and ``below`` of it and both, blended by ``fx`` and ``fy``."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        vector = ir.VectorType(ir.FloatType(), 4)
        address = _addressing(context, builder, signature, arguments, vector)
        _, i, _, j, right, below, fx, fy = arguments
        under = builder.add(j, below)
        a, b, c, d = (
            _load(builder, address(2, k)) for k in (j, builder.add(j, right), under, builder.add(under, right))
        )

        def all_four(number: Any) -> Any:
            one = builder.insert_element(ir.Constant(vector, ir.Undefined), number, ir.IntType(32)(0))
            return builder.shuffle_vector(one, one, ir.Constant(ir.VectorType(ir.IntType(32), 4), [0] * 4))

        def mix(a: Any, b: Any, share: Any) -> Any:
            change = builder.fmul(share, builder.fsub(b, a, flags=("contract",)), flags=("contract",))
            return builder.fadd(a, change, flags=("contract",))

        x, y = all_four(fx), all_four(fy)
        _store(builder, mix(mix(a, b, x), mix(c, d, x), y), address(0, i))
        return context.get_dummy_value()

    return types.void(to, i, source, j, right, below, fx, fy), codegen


def _addressing(context: Any, builder: Any, signature: Any, arguments: Any, vector: Any) -> Any:
    def address(argument: int, index: Any) -> Any:
        data = context.make_array(signature.args[argument])(context, builder, arguments[argument]).data
        return builder.bitcast(builder.gep(data, [index]), vector.as_pointer())

    return address


def _load(builder: Any, pointer: Any) -> Any:
    value = builder.load(pointer)
    value.align = 4
    return value


def _store(builder: Any, value: Any, pointer: Any) -> None:
    builder.store(value, pointer).align = 4
