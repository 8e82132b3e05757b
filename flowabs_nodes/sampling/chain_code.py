"""Walks written down, four bits a step, for a filter that takes them again: the flow stays, the picture changes.

Of each step the move is kept, from the pixel nearest to the last point to the one nearest to the next, both inside the
picture: 4 (rows + 1) + columns + 1, eight steps in 32 bits. Following moves costs a fraction of walking the flow
(:mod:`~flowabs_nodes.sampling.streamline`) and leads to the same pixels.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

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
from flowabs_nodes.simd.lanes import LANES, absolute, any_lane, lane_indices, maximum, minimum, splat_floats, splat_ints
from flowabs_nodes.simd.memory import load, prefetch, prefetch_for_write, scratch, store
from flowabs_nodes.simd.target import PATH

ChainCode = npt.NDArray[np.int32]  # (H, words, 2 ways, row in memory), in one dimension

STEPS = 8  # in a word
MOST_STEPS = 16
AHEAD = 128  # pixels: what is fetched while these are worked on

_STAY = 0x55555555  # eight times 4 (0 + 1) + 0 + 1


def encode_streamlines(flow: Any, steps: int, raster: Raster) -> ChainCode | None:
    """The moves along the flow, ``steps`` each way; None where they are too many, or longer than a pixel.

    Of unit tangents no step is, unless an offset is exactly between two pixels.
    """
    if steps > MOST_STEPS:
        return None
    chain = np.empty(raster.height * -(-steps // STEPS) * 2 * raster.stride, np.int32)
    fitting = over_rows(_write, raster.height, flow, steps, raster, chain)
    return chain if all(fitting) else None


@kernel
def _write(first: int, last: int, flow: Any, steps: int, raster: Raster, chain: Any) -> Any:
    """Whether all of them fit."""
    curves, place, word = new_streamlines(), scratch(np.int32, BLOCKS), scratch(np.int32, BLOCKS)
    row = (steps + STEPS - 1) // STEPS * 2 * raster.stride
    wrong, longest = splat_ints(0), splat_floats(0.0)
    for y in range(first, last):
        for x0 in range(0, raster.stride, BATCH // 2):
            start(curves, flow, x0, y, raster)
            for at in range(0, BATCH, LANES):
                x = block_column(x0, at, raster)
                prefetch_tangents(flow, x, y, steps + 1, raster)
                prefetch_for_write(chain, y * row + at // LANES % 2 * raster.stride + x + AHEAD)
                store(place, at, _place(minimum(lane_indices() + x, raster.width - 1), splat_ints(y)))
                store(word, at, splat_ints(_STAY))
                longest = maximum(longest, maximum(absolute(load(curves.tx, at)), absolute(load(curves.ty, at))))
            for s in range(steps):
                for at in range(0, BATCH, LANES):
                    here = _place(*advance(curves, at, block_column(x0, at, raster), y, raster))
                    now = load(word, at) + ((here - load(place, at)) << (4 * (s % STEPS)))
                    store(place, at, here)
                    store(word, at, now)
                    if s % STEPS == STEPS - 1 or s == steps - 1:
                        way = s // STEPS * 2 + at // LANES % 2
                        store(chain, y * row + way * raster.stride + block_column(x0, at, raster), now)
                        store(word, at, splat_ints(_STAY))
                        wrong = wrong | (now & (now >> 1))
                if s < steps - 1:
                    turn(curves, flow)
    # A move of 2 has both bits set of its rows or its columns, and no tangent up to 1.5 makes a longer one.
    return not (any_lane((wrong & _STAY) > 0) or any_lane(longest > 1.5))


@inlined
def _place(x: Any, y: Any) -> Any:
    """Differences of these are moves."""
    return (y << 2) + x


if PATH == "avx512":  # a table of what each of the sixteen moves changes in the place of a record of ``size`` floats

    @inlined
    def _changes(raster: Raster, size: int) -> Any:
        move = lane_indices()
        return (((move >> 2) - 1) * raster.stride + (move & 3) - 1) * size

    _first_change = table_lookup  # that of the first move in a word
else:

    @inlined
    def _changes(raster: Raster, size: int) -> tuple[int, int]:
        return raster.stride * size, size

    @inlined
    def _first_change(changes: tuple[int, int], word: Any) -> Any:
        row, block_column = changes
        return ((word >> 2) & 3) * row + (word & 3) * block_column - (row + block_column)


@inlined
def decode_offsets(chain: Any, steps: int, x: int, y: int, raster: Raster, size: int, places: Any, at: int) -> None:
    """Write the places of the records at each step, by turns along and against the flow, to ``places`` from [at] on."""
    along = against = (lane_indices() + (y * raster.stride + x)) * size
    changes = _changes(raster, size)
    word = y * ((steps + STEPS - 1) // STEPS) * 2 * raster.stride + x
    one, other = _words(chain, word, raster)
    for s in range(steps):
        if s == STEPS:  # of MOST_STEPS: there is no third word
            one, other = _words(chain, word + 2 * raster.stride, raster)
        along, against = along + _first_change(changes, one), against + _first_change(changes, other)
        one, other = one >> 4, other >> 4
        store(places, at + 2 * LANES * s, along)
        store(places, at + 2 * LANES * s + LANES, against)


@inlined
def _words(chain: Any, word: int, raster: Raster) -> Any:
    """Those of both ways."""
    prefetch(chain, word + AHEAD)
    prefetch(chain, word + raster.stride + AHEAD)
    return load(chain, word), load(chain, word + raster.stride)
