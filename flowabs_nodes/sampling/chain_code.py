"""Chain codes of streamlines, for a filter that follows the same flow again in each of its iterations.

A Freeman chain code records, for each step, the move from the pixel nearest to one point of a streamline to the pixel
nearest to the next, both clamped to the picture. Here a move takes four bits, 4 (rows + 1) + (columns + 1), and eight
of them a word of 32 bits. Decoding costs a fraction of following the flow (:mod:`~flowabs_nodes.sampling.streamline`)
and leads to the same pixels.
"""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Complex64, Int32
from flowabs_nodes.sampling.coords import Raster
from flowabs_nodes.sampling.streamline import (
    BATCH,
    BLOCKS,
    advance,
    block_column,
    new_streamlines,
    prefetch_tangents,
    start,
    turn,
)
from flowabs_nodes.simd.avx512 import table_lookup
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import (
    LANES,
    Ints,
    absolute,
    any_lane,
    lane_indices,
    maximum,
    minimum,
    splat_floats,
    splat_ints,
)
from flowabs_nodes.simd.memory import load, prefetch, prefetch_for_write, scratch, store
from flowabs_nodes.simd.target import PATH

#: (H, words, 2, stride) flattened: for each row and each eight steps, the words along the flow, then those against it.
ChainCode = Int32

#: Steps in a word.
STEPS = 8
#: The most steps to each side that a chain code can hold.
MOST_STEPS = 16
#: How many pixels ahead of the pixel at work memory is fetched.
AHEAD = 128

_STAY = 0x55555555  # eight moves by 0 rows and 0 columns, 4 (0 + 1) + (0 + 1) each


def encode_streamlines(flow: Complex64, steps: int, raster: Raster) -> ChainCode | None:
    """Return the chain codes of the streamlines of all pixels, ``steps`` along and against the flow.

    Returns None if there are more than MOST_STEPS steps, or if one moves by more than a row or a column. A step along a
    unit tangent does not, unless a point lies exactly half way between two pixels. ``flow`` is (H, stride) complex64,
    flattened.
    """
    if steps > MOST_STEPS:
        return None
    chain = np.empty(raster.height * -(-steps // STEPS) * 2 * raster.stride, np.int32)
    fitting = over_rows(_encode, raster.height, flow, steps, raster, chain)
    return chain if all(fitting) else None


@kernel
def _encode(first: int, last: int, flow: Complex64, steps: int, raster: Raster, chain: ChainCode) -> bool:
    """Write the chain codes of the rows first .. last - 1, and return whether no move is longer than a pixel.

    Streamlines start 64 pixels at a time (:class:`~flowabs_nodes.sampling.streamline.Streamlines`).
    """
    curves, position, word = new_streamlines(), scratch(np.int32, BLOCKS), scratch(np.int32, BLOCKS)
    row = (steps + STEPS - 1) // STEPS * 2 * raster.stride
    long_moves, longest = splat_ints(0), splat_floats(0.0)
    for y in range(first, last):
        for x0 in range(0, raster.stride, BATCH // 2):
            start(curves, flow, x0, y, raster)
            for at in range(0, BATCH, LANES):
                x = block_column(x0, at, raster)
                prefetch_tangents(flow, x, y, steps + 1, raster)
                prefetch_for_write(chain, y * row + at // LANES % 2 * raster.stride + x + AHEAD)
                store(position, at, _position(minimum(lane_indices() + x, raster.width - 1), splat_ints(y)))
                store(word, at, splat_ints(_STAY))
                longest = maximum(longest, maximum(absolute(load(curves.tx, at)), absolute(load(curves.ty, at))))
            for s in range(steps):
                for at in range(0, BATCH, LANES):
                    here = _position(*advance(curves, at, block_column(x0, at, raster), y, raster))
                    now = load(word, at) + ((here - load(position, at)) << (4 * (s % STEPS)))
                    store(position, at, here)
                    store(word, at, now)
                    if s % STEPS == STEPS - 1 or s == steps - 1:
                        line = s // STEPS * 2 + at // LANES % 2
                        store(chain, y * row + line * raster.stride + block_column(x0, at, raster), now)
                        store(word, at, splat_ints(_STAY))
                        long_moves = long_moves | (now & (now >> 1))
                if s < steps - 1:
                    turn(curves, flow)
    # A tangent up to 1.5 moves by 2 rows (or columns) at most. Both bits of the rows (or columns) are then set.
    fits: bool = not (any_lane((long_moves & _STAY) > 0) or any_lane(longest > 1.5))
    return fits


@inlined
def _position(x: Ints, y: Ints) -> Ints:
    """Return the position of a pixel as one number. The difference of two is the move, less that of staying."""
    return (y << 2) + x


if PATH == "avx512":  # one instruction looks up the offsets of sixteen moves

    @inlined
    def _offset_table(raster: Raster, size: int) -> Ints:
        """Return, for each of the sixteen moves, the offset of its record from the last one, in floats."""
        move = lane_indices()
        return (((move >> 2) - 1) * raster.stride + (move & 3) - 1) * size

    _first_offset = table_lookup  # by the lowest four bits of each word
else:

    @inlined
    def _offset_table(raster: Raster, size: int) -> tuple[int, int]:
        """Return the offsets of the records one row and one column further, in floats."""
        return raster.stride * size, size

    @inlined
    def _first_offset(offsets: tuple[int, int], word: Ints) -> Ints:
        """Return the offset that the first move of each word makes."""
        row, column = offsets
        return ((word >> 2) & 3) * row + (word & 3) * column - (row + column)


@inlined
def decode_offsets(
    chain: ChainCode, steps: int, x: int, y: int, raster: Raster, size: int, places: Int32, at: int
) -> None:
    """Write the indices of the records along the streamlines of the pixels x .. x + 15 of row y.

    ``places`` (scratch memory) takes, from index ``at`` on, sixteen indices for the first step along the flow, sixteen
    for the first step against it, then those of the second step and so on. ``size`` is the number of floats in a record
    of the picture, which has the ``raster`` of the flow.
    """
    along = against = (lane_indices() + (y * raster.stride + x)) * size
    offsets = _offset_table(raster, size)
    word = y * ((steps + STEPS - 1) // STEPS) * 2 * raster.stride + x
    forward, backward = _load_words(chain, word, raster)
    for s in range(steps):
        if s == STEPS:  # of MOST_STEPS: there is no third word
            forward, backward = _load_words(chain, word + 2 * raster.stride, raster)
        along, against = along + _first_offset(offsets, forward), against + _first_offset(offsets, backward)
        forward, backward = forward >> 4, backward >> 4
        store(places, at + 2 * LANES * s, along)
        store(places, at + 2 * LANES * s + LANES, against)


@inlined
def _load_words(chain: ChainCode, word: int, raster: Raster) -> tuple[Ints, Ints]:
    """Return sixteen words along the flow, from index ``word`` on, and the words of the same pixels against it."""
    prefetch(chain, word + AHEAD)
    prefetch(chain, word + raster.stride + AHEAD)
    return load(chain, word), load(chain, word + raster.stride)
