"""Kernels take read-only arrays as what they are compiled for, without a copy wherever that can be."""

from typing import Any, NamedTuple

import numpy as np
import pytest

from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.read_only import for_kernel, read_only


class Pair(NamedTuple):
    one: Any
    other: Any


def test_a_view_cannot_be_written_to_and_the_array_can() -> None:
    array = np.zeros(3, np.float32)
    view = read_only(array)
    with pytest.raises(ValueError, match="read-only"):
        view[0] = 1
    array[0] = 1
    assert view[0] == 1
    assert read_only(view) is view


def test_kernels_get_writable_views_of_the_same_memory() -> None:
    array = np.arange(6, dtype=np.float32)
    view = read_only(array.reshape(2, 3))
    found = for_kernel(view)
    assert found.flags.writeable
    assert np.shares_memory(found, array)
    assert not view.flags.writeable
    assert for_kernel(array) is array
    assert for_kernel("lab") == "lab"


def test_arrays_in_tuples_count_too() -> None:
    view = read_only(np.zeros(3, np.float32))
    pair = for_kernel(Pair(view, (view, 1.5)))
    assert type(pair) is Pair
    assert pair.one.flags.writeable
    assert pair.other[0].flags.writeable
    assert pair.other[1] == 1.5


def test_memory_that_nobody_may_write_to_is_copied() -> None:
    array = np.frombuffer(bytes(12), np.float32)
    found = for_kernel(array)
    assert found.flags.writeable
    assert not np.shares_memory(found, array)
    np.testing.assert_array_equal(found, array)


def test_a_kernel_is_compiled_once_for_both() -> None:
    @kernel
    def total(first, last, pair):  # type: ignore[no-untyped-def]
        one, other = pair
        return one[first] + other[first]

    array = np.ones(1, np.float32)
    for each in (array, read_only(array), np.frombuffer(np.float32(1).tobytes(), np.float32)):
        assert over_rows(total, 1, Pair(each, array)) == [2]
    assert len(total.signatures) == 1
