"""Walks written down, a byte a step, for a filter that takes them again: the flow stays, the picture changes.

Of each step the move is kept, from the pixel nearest to the last point to the one nearest to the next, both inside the
picture. Following moves costs a quarter of walking the flow (:mod:`~flowabs_nodes.filters.walk`) and leads to the same
pixels.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from numba import prange

from flowabs_nodes.filters.arguments import Array
from flowabs_nodes.filters.blocks import COLUMNS, Block, first_pixel, inline, scratch, u
from flowabs_nodes.filters.kernels import kernel, parallel_kernel
from flowabs_nodes.filters.walk import new_walk, start, step

Moves = npt.NDArray[np.int8]  # (H, 2 ways, steps, W): 16 rows + columns + 8

MOST_STEPS = 16  # 32 bytes a pixel: what two pictures of records take
LONGEST = 6  # tangents of at most this length move by at most 7 rows and 7 columns, 4 bits each
NARROWEST = 16  # from this width on, rows and columns of such a move follow from the change of index


def written_walks(flow: Array, steps: int) -> Moves | None:
    """The moves along the flow, ``steps`` each way; None where they do not fit into bytes, or these into memory."""
    height, width, _ = flow.shape
    if steps > MOST_STEPS or width < NARROWEST or flow.min() < -LONGEST or flow.max() > LONGEST:
        return None
    moves = np.empty((height, 2, steps, width), np.int8)
    _write(flow, moves)
    return moves


@inline
def stay(pixel: Any, block: Block) -> None:
    """Begin at the centres."""
    for i in range(block.size):
        pixel[i] = np.int32(first_pixel(block) + i)


@inline
def follow(moves: Any, pixel: Any, block: Block) -> None:
    """One step further; ``moves`` are those of this step and way, for the whole row."""
    width = np.int32(block.width)
    for i in range(block.size):
        move = np.int32(moves[u(block.x) + i])
        rows, columns = np.int32(move >> 4), np.int32(np.int32(move & 15) - 8)
        pixel[i] += np.int32(rows * width) + columns


@parallel_kernel
def _write(flow: Any, moves: Any) -> None:
    height, width, _ = flow.shape
    tangents = flow.reshape(-1)
    for y in prange(height):
        _write_row(tangents, np.int64(y), width, height, moves[y])


@kernel
def _write_row(flow: Any, y: int, width: int, height: int, moves: Any) -> None:
    walk, last = new_walk(), scratch(np.int32, 1)
    for x in range(0, width, COLUMNS):
        block = Block(x, y, u(min(COLUMNS, width - x)), width, height)
        for way in range(2):
            start(walk, flow, way, block)
            stay(last, block)
            for s in range(moves.shape[1]):
                step(walk, flow, block)
                _write_step(last, walk.pixel, moves[u(way), u(s)], block)


@inline
def _write_step(last: Any, pixel: Any, moves: Any, block: Block) -> None:
    """The move from ``last`` to ``pixel``, which becomes the last."""
    for i in range(block.size):
        change = np.float64(pixel[i] - last[i])
        rows = np.rint(change / np.float64(block.width))
        columns = change - rows * np.float64(block.width)
        moves[u(block.x) + i] = np.int8(16 * rows + columns + 8)
        last[i] = pixel[i]
