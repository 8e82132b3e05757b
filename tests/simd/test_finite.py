import numpy as np
import pytest

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.simd.finite import is_finite, refuse_non_finite


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
    with pytest.raises(ArgumentError, match="code: expected finite pixels, found 2 that are NaN or Inf") as caught:
        refuse_non_finite("code", array)
    assert caught.value.parameter == "code"
