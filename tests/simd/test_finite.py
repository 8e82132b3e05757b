import numpy as np
import pytest

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.simd.finite import (
    LARGEST,
    is_finite,
    is_summable,
    refuse_enormous,
    refuse_non_finite,
    refuse_overflow,
)


@pytest.mark.parametrize("size", [1, 15, 16, 17, 1000])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_one_bad_number_is_found_wherever_it_is(size, bad):
    for place in {0, size // 2, size - 1}:
        array = np.full(size, -np.finfo(np.float32).max)
        array = array.astype(np.float32)
        assert is_finite(array)
        array[place] = bad
        assert not is_finite(array)


def test_the_error_names_the_argument_and_counts():
    array = np.zeros((3, 4), np.float32)
    refuse_non_finite("code", array)
    array[0, 0], array[1, 2] = np.nan, -np.inf
    with pytest.raises(
        ArgumentError, match="code: expected finite pixels, found 2 that are NaN or Inf, the first at x 0"
    ) as caught:
        refuse_non_finite("code", array)
    assert caught.value.parameter == "code"


@pytest.mark.parametrize("size", [1, 15, 16, 17, 1000])
@pytest.mark.parametrize("bad", [np.nan, np.inf, 1.1 * LARGEST, -1.1 * LARGEST, np.finfo(np.float32).max])
def test_one_number_beyond_what_sums_hold_is_found_wherever_it_is(size, bad):
    for place in {0, size // 2, size - 1}:
        array = np.full(size, -LARGEST, np.float32)
        assert is_summable(array)
        array[place] = bad
        assert not is_summable(array)


def test_errors_say_where_and_what_was_there():
    array = np.ones((3, 4, 2), np.float32)
    refuse_enormous("image", array)
    refuse_overflow("image", array, array)
    array[2, 1, 1] = -1e35
    with pytest.raises(ArgumentError, match=r"image: expected numbers up to 1.04e\+34, found 1 .* -1e\+35 at x 1, y 2"):
        refuse_enormous("image", array)
    result = np.where(array < 0, -np.inf, array)
    with pytest.raises(
        ArgumentError, match=r"image: .* found larger ones in 1 pixels, the first 1 -1e\+35 at x 1, y 2"
    ):
        refuse_overflow("image", array, result)
