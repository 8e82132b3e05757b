import numpy as np
from numba import njit

from flowabs_nodes.simd.exponential import exp2


@njit
def each(numbers):
    powers = np.empty_like(numbers)
    for i in range(numbers.size):
        powers[i] = exp2(numbers[i])
    return powers


def test_powers_of_2():
    numbers = -np.concatenate([np.linspace(0, 100, 200_001), np.geomspace(1e-30, 100, 10_001)]).astype(np.float32)
    np.testing.assert_allclose(each(numbers), 2.0 ** numbers.astype(np.float64), rtol=3e-7)


def test_what_is_too_small_to_count():
    powers = each(np.array([-100.5, -1e5, -1e38, -np.inf], np.float32))
    assert ((powers >= 0) & (powers <= 1e-30)).all()
