"""Reading and writing vectors against NumPy: neighbours, records, scattered records, scratch memory."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from flowabs_nodes.simd import lanes, memory
from flowabs_nodes.simd.lanes import LANES
from flowabs_nodes.simd.memory import load, store
from tests.simd.test_lanes import X

PICTURE = np.arange(100, dtype=np.float32) ** 2
PLACES = np.random.default_rng(16).integers(0, 92, LANES).astype(np.int32)


@njit
def _read_at_places(picture: Any, places: Any, out: Any) -> None:
    kept = memory.scratch(np.int32, 2)
    store(kept, 16, load(places, 0))
    for k, each in enumerate(memory.gather_pairs(picture, kept, 16)):
        store(out, 16 * k, each)
    for k, each in enumerate(memory.gather_quads(picture, kept, 16)):
        store(out, 32 + 16 * k, each)
    for k, each in enumerate(memory.gather_octets(picture, kept, 16)):
        store(out, 96 + 16 * k, each)


def test_reading_at_scattered_places() -> None:
    out = np.zeros(14 * LANES, np.float32)
    _read_at_places(PICTURE, PLACES, out)
    offsets = [*range(2), *range(4), *range(8)]
    np.testing.assert_array_equal(out.reshape(14, LANES), [PICTURE[PLACES + k] for k in offsets])


@njit
def _read_further_on(picture: Any, pairs: Any, out: Any) -> None:
    later = memory.address(memory.address(picture, 3), 4)
    store(out, 0, load(later, 1))
    for k, each in enumerate(memory.load_pairs(memory.address(pairs, 2), 0)):
        store(out, 16 + 16 * k, each)
    store(memory.address(out, 48), 0, load(picture, 0))


def test_an_address_is_the_memory_of_an_array_from_an_item_on() -> None:
    out, pairs = np.zeros(4 * LANES, np.float32), (PICTURE + 1j).astype(np.complex64)
    _read_further_on(PICTURE, pairs, out)
    expected = [PICTURE[8:24], pairs[2:18].real, pairs[2:18].imag, PICTURE[:16]]
    np.testing.assert_array_equal(out.reshape(4, LANES), expected)


@njit
def _read_pairs(picture: Any, places: Any, out: Any) -> None:
    kept = memory.scratch(np.int32, 1)
    store(kept, 0, load(places, 0))
    for k, each in enumerate(memory.gather_quads(picture, kept, 0)):
        store(out, 16 * k, each)
    for k, each in enumerate(memory.load_pairs(picture, 3)):
        store(out, 64 + 16 * k, each)
    memory.store_pairs(picture, 3, (load(out, 0), load(out, 16)))


def test_complex_numbers_are_pairs() -> None:
    out, picture = np.zeros(6 * LANES, np.float32), PICTURE[: PICTURE.size // 2 * 2].copy()
    numbers, places = picture.view(np.complex64), (PLACES // 2).astype(np.int32)
    _read_pairs(numbers, places, out)
    expected = [PICTURE[2 * places + k] for k in range(4)]
    neighbours = PICTURE[6 : 6 + 2 * LANES]
    np.testing.assert_array_equal(out.reshape(6, LANES), [*expected, neighbours[::2], neighbours[1::2]])
    np.testing.assert_array_equal(picture[6 : 6 + 2 * LANES], np.stack(expected[:2], -1).ravel())


@njit
def _by_way_of_scratch(x: Any, whole: Any, nearest: Any, ties_to_even: Any, below: Any) -> None:
    kept = memory.scratch(np.float64, 3)
    store(kept, 32, lanes.to_doubles(load(x, 0)))
    memory.prefetch(x, 10**9)  # only ever a hint
    memory.prefetch_for_write(x, -1)
    store(whole, 0, lanes.to_ints(load(kept, 32)))
    store(nearest, 0, lanes.rint(load(kept, 32)))
    store(ties_to_even, 0, lanes.round_to_ints(load(kept, 32)))
    store(below, 0, lanes.floor(load(kept, 32)))


def test_doubles_in_scratch_memory() -> None:
    whole, even = np.zeros((2, LANES), np.int32)
    nearest, below = np.zeros((2, LANES))
    x = np.where(np.arange(LANES) < 8, np.arange(LANES) - 3.5, X).astype(np.float32)
    _by_way_of_scratch(x, whole, nearest, even, below)
    np.testing.assert_array_equal(whole, np.trunc(x))
    np.testing.assert_array_equal(nearest, np.rint(x))
    np.testing.assert_array_equal(even, np.rint(x))
    np.testing.assert_array_equal(below, np.floor(x))


@njit
def _take_apart(records: Any, out: Any, again: Any) -> None:
    pairs, triples = memory.load_pairs(records, 1), memory.load_triples(records, 1)
    quads = memory.load_quads(records, 1)
    for k in range(2):
        store(out, 16 * k, pairs[k])
    for k in range(3):
        store(out, 32 + 16 * k, triples[k])
    for k in range(4):
        store(out, 80 + 16 * k, quads[k])
    memory.store_pairs(again, 0, pairs)
    memory.store_triples(again, 32, triples)
    memory.store_quads(again, 80, quads)


def test_neighbouring_records_come_apart_and_together() -> None:
    out, again = np.zeros(9 * LANES, np.float32), np.zeros(9 * LANES, np.float32)
    _take_apart(PICTURE, out, again)
    first = 0
    for size in (2, 3, 4):
        last = first + size * LANES
        records = PICTURE[1 : 1 + size * LANES]
        np.testing.assert_array_equal(out[first:last].reshape(size, LANES), records.reshape(LANES, size).T)
        np.testing.assert_array_equal(again[first:last], records)
        first = last
