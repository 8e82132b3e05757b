"""Walks written down, four bits a step, for a filter that takes them again: the flow stays, the picture changes.

Of each step the move is kept, from the pixel nearest to the last point to the one nearest to the next, both inside the
picture: 4 (rows + 1) + columns + 1, eight steps in 32 bits. Following moves costs a fraction of walking the flow
(:mod:`~flowabs_nodes.sampling.streamline`) and leads to the same pixels.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.sampling.coords import Frame
from flowabs_nodes.sampling.streamline import ALL, TOGETHER, advance, column, expect_tangents, new_walks, set_out, turn
from flowabs_nodes.simd.avx512 import look_up
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.lanes import (
    LANES,
    absolute,
    any_lane,
    inlined,
    lane_numbers,
    maximum,
    minimum,
    same_floats,
    same_ints,
)
from flowabs_nodes.simd.memory import load, scratch, soon_read, soon_written, store
from flowabs_nodes.simd.target import PATH

Moves = npt.NDArray[np.int32]  # (H, words, 2 ways, row in memory), in one dimension

STEPS = 8  # in a word
MOST_STEPS = 16
AHEAD = 128  # pixels: what is fetched while these are worked on

_STAY = 0x55555555  # eight times 4 (0 + 1) + 0 + 1


def written_walks(flow: Any, steps: int, frame: Frame) -> Moves | None:
    """The moves along the flow, ``steps`` each way; None where they are too many, or longer than a pixel.

    Of unit tangents no step is, unless an offset is exactly between two pixels.
    """
    if steps > MOST_STEPS:
        return None
    moves = np.empty(frame.height * -(-steps // STEPS) * 2 * frame.stride, np.int32)
    fitting = over_rows(_write, frame.height, flow, steps, frame, moves)
    return moves if all(fitting) else None


@kernel
def _write(first: int, last: int, flow: Any, steps: int, frame: Frame, moves: Any) -> Any:
    """Whether all of them fit."""
    walks, place, word = new_walks(), scratch(np.int32, TOGETHER), scratch(np.int32, TOGETHER)
    row = (steps + STEPS - 1) // STEPS * 2 * frame.stride
    wrong, longest = same_ints(0), same_floats(0.0)
    for y in range(first, last):
        for x0 in range(0, frame.stride, ALL // 2):
            set_out(walks, flow, x0, y, frame)
            for at in range(0, ALL, LANES):
                x = column(x0, at, frame)
                expect_tangents(flow, x, y, steps + 1, frame)
                soon_written(moves, y * row + at // LANES % 2 * frame.stride + x + AHEAD)
                store(place, at, _place(minimum(lane_numbers() + x, frame.width - 1), same_ints(y)))
                store(word, at, same_ints(_STAY))
                longest = maximum(longest, maximum(absolute(load(walks.tx, at)), absolute(load(walks.ty, at))))
            for s in range(steps):
                for at in range(0, ALL, LANES):
                    here = _place(*advance(walks, at, column(x0, at, frame), y, frame))
                    now = load(word, at) + ((here - load(place, at)) << (4 * (s % STEPS)))
                    store(place, at, here)
                    store(word, at, now)
                    if s % STEPS == STEPS - 1 or s == steps - 1:
                        way = s // STEPS * 2 + at // LANES % 2
                        store(moves, y * row + way * frame.stride + column(x0, at, frame), now)
                        store(word, at, same_ints(_STAY))
                        wrong = wrong | (now & (now >> 1))
                if s < steps - 1:
                    turn(walks, flow)
    # A move of 2 has both bits set of its rows or its columns, and no tangent up to 1.5 makes a longer one.
    return not (any_lane((wrong & _STAY) > 0) or any_lane(longest > 1.5))


@inlined
def _place(x: Any, y: Any) -> Any:
    """Differences of these are moves."""
    return (y << 2) + x


if PATH == "avx512":  # a table of what each of the sixteen moves changes in the place of a record of ``size`` floats

    @inlined
    def _changes(frame: Frame, size: int) -> Any:
        move = lane_numbers()
        return (((move >> 2) - 1) * frame.stride + (move & 3) - 1) * size

    _first_change = look_up  # that of the first move in a word
else:

    @inlined
    def _changes(frame: Frame, size: int) -> tuple[int, int]:
        return frame.stride * size, size

    @inlined
    def _first_change(changes: tuple[int, int], word: Any) -> Any:
        row, column = changes
        return ((word >> 2) & 3) * row + (word & 3) * column - (row + column)


@inlined
def follow(moves: Any, steps: int, x: int, y: int, frame: Frame, size: int, places: Any, at: int) -> None:
    """Write the places of the records at each step, by turns along and against the flow, to ``places`` from [at] on."""
    along = against = (lane_numbers() + (y * frame.stride + x)) * size
    changes = _changes(frame, size)
    word = y * ((steps + STEPS - 1) // STEPS) * 2 * frame.stride + x
    one, other = _words(moves, word, frame)
    for s in range(steps):
        if s == STEPS:  # of MOST_STEPS: there is no third word
            one, other = _words(moves, word + 2 * frame.stride, frame)
        along, against = along + _first_change(changes, one), against + _first_change(changes, other)
        one, other = one >> 4, other >> 4
        store(places, at + 2 * LANES * s, along)
        store(places, at + 2 * LANES * s + LANES, against)


@inlined
def _words(moves: Any, word: int, frame: Frame) -> Any:
    """Those of both ways."""
    soon_read(moves, word + AHEAD)
    soon_read(moves, word + frame.stride + AHEAD)
    return load(moves, word), load(moves, word + frame.stride)
